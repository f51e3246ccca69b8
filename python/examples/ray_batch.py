"""Many models through Ray: orientations of a data set, restartable, on one computer or on many.

    python ray_batch.py OUT [--models 200] [--workers 2] [--check]

200 solids are generated (each a turned, tapered prism), oriented by staircase error and support volume, and their documents written to OUT, one file each, named
by the hash of model, options and version: what is there already is not done again. With `--check` the same is done in one process,
through Ray with one and with two workers, and once more with a worker killed in the midst; the results must be the same, and the figures
are printed as JSON. For a data set of your own, replace `generated`; for a cluster, give `ray.init` its address.
"""

import argparse
import hashlib
import itertools
import json
import os
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

import trunnion

#: How each model is asked for; part of the name of its result.
OPTIONS = {"objective": ["staircase", "support-volume"], "method": "multistart", "seed": 1}
#: Tasks under way for each worker: enough that none waits, few enough that a million models are not all in memory.
AHEAD = 4


def generated(count):
    """`count` models, each a dict with its name and the bytes of its file; the same whenever they are asked for."""
    for number in range(count):
        draw = np.random.default_rng(number)
        sides = int(draw.integers(5, 40))
        around = np.sort(draw.uniform(0, 2 * np.pi, sides)) if number % 2 else np.arange(sides) * 2 * np.pi / sides
        ring = np.stack([np.cos(around), np.sin(around), np.zeros(sides)], axis=1) * draw.uniform(5, 20)
        top = ring * draw.uniform(0.3, 1.0) + [0, 0, draw.uniform(5, 40)]
        turn, _ = np.linalg.qr(draw.normal(size=(3, 3)))
        turn *= np.linalg.det(turn)
        vertices = np.concatenate([ring, top, [[0, 0, 0]], [top.mean(axis=0) * [0, 0, 1]]]) @ turn.T
        after = (np.arange(sides) + 1) % sides
        low = np.stack([after, np.arange(sides), np.full(sides, 2 * sides)], axis=1)
        high = np.stack([np.arange(sides) + sides, after + sides, np.full(sides, 2 * sides + 1)], axis=1)
        walls = [[[i, j, i + sides], [j, j + sides, i + sides]] for i, j in enumerate(after)]
        facets = np.concatenate([low, high, np.reshape(walls, (-1, 3))])
        # Every fiftieth is broken: half of it is missing.
        model = trunnion.Model.from_arrays(vertices, facets[: sides if number % 50 == 7 else None])
        yield {"name": f"solid-{number:04}", "data": model.data}


def key_of(data):
    """What a model's result is called."""
    options = json.dumps([trunnion.__version__, OPTIONS], sort_keys=True)
    return hashlib.sha256(options.encode() + data).hexdigest()


def one(row, out, log=None):
    """Orients one model and writes its document; runs on a worker. Fails as a row, never as a task: the same words would fail again."""
    key = key_of(row["data"])
    path = Path(out) / key[:2] / f"{key}.json"
    found = {"name": row["name"], "key": key, "worker": os.getpid()}
    if path.exists():
        return {**found, "status": "skipped", "error": ""}
    if log is not None:
        with open(log, "a") as begun:
            begun.write(f"{row['name']} {os.getpid()}\n")
    try:
        # One thread each: there are as many workers as processors.
        done = trunnion.orient(trunnion.Model(row["name"] + ".3mf", row["data"]), threads=1, **OPTIONS)
    except trunnion.InputError as error:
        return {**found, "status": "failed", "error": str(error)}
    path.parent.mkdir(parents=True, exist_ok=True)
    # Written beside its place and moved there: a worker that is killed leaves no half of a document.
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False) as beside:
        beside.write(done.to_json())
    os.replace(beside.name, path)
    return {**found, "status": "done", "error": ""}


def here(rows, out):
    """All of them in this process, one after the other."""
    return [one(row, out) for row in rows]


def by_ray(rows, out, workers, kill=False, log=None):
    """All of them through Ray, given back as they are done; `kill` ends a worker that is at work when a third is done.

    A worker that is lost loses the model that it was at, which Ray does again elsewhere.
    """
    import ray

    task = ray.remote(num_cpus=1, max_retries=5)(one)
    waiting, running, done = iter(rows), [], []
    while True:
        running += [task.remote(row, str(out), log) for row in itertools.islice(waiting, AHEAD * workers - len(running))]
        if not running:
            return done
        ready, running = ray.wait(running)
        done += ray.get(ready)
        if kill and len(done) >= len(rows) // 3:
            kill = not killed_at_work({row["name"] for row in done}, log)


def killed_at_work(done, log):
    """Kills a worker that has begun a model and not ended it; whether there was one."""
    begun = [line.split() for line in Path(log).read_text().splitlines()]
    at_work = [int(pid) for name, pid in begun if name not in done]
    if at_work:
        os.kill(at_work[-1], signal.SIGKILL)
    return bool(at_work)


def with_ray(workers, work):
    """What `work` gives with so many workers at hand."""
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    import ray

    ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False, logging_level="error", object_store_memory=128 << 20)
    try:
        # Workers begin, and import what they need, before the clock does.
        ray.get([ray.remote(num_cpus=1)(lambda: trunnion.__version__).remote() for _ in range(2 * workers)])
        return work()
    finally:
        ray.shutdown()


def documents(out):
    """All results below a folder, by key, without what a clock says."""

    def untimed(value):
        if isinstance(value, dict):
            return {key: untimed(one) for key, one in value.items() if key != "seconds"}
        return [untimed(one) for one in value] if isinstance(value, list) else value

    return {path.stem: untimed(json.loads(path.read_text())) for path in sorted(Path(out).glob("*/*.json"))}


def check(rows, out):
    """Holds Ray's results against those of one process; figures, and whether all is the same."""
    log = str(out / "begun.txt")

    def timed(work):
        began = time.perf_counter()
        done = work()
        return done, round(time.perf_counter() - began, 2)

    alone, seconds = timed(lambda: here(rows, out / "alone"))
    figures = {"models": len(rows), "failed": sum(row["status"] == "failed" for row in alone), "alone_s": seconds}
    expected = documents(out / "alone")
    told = sorted((row["name"], row["key"], row["status"], row["error"]) for row in alone)
    same = len(expected) + figures["failed"] == len(rows)
    for name, workers, kill in [("one_worker", 1, False), ("two_workers", 2, False), ("one_of_two_killed", 2, True)]:
        Path(log).write_text("")
        folder = out / name
        done, seconds = with_ray(workers, lambda: timed(lambda: by_ray(rows, folder, workers, kill, log)))
        # What a killed task had done before it was killed is skipped when it is done again.
        again = [row["status"].replace("skipped", "done") for row in done]
        equal = told == sorted((row["name"], row["key"], status, row["error"]) for row, status in zip(done, again))
        begun = Counter(line.split()[0] for line in Path(log).read_text().splitlines())
        figures[name + "_s"] = seconds
        figures[name + "_same"] = equal and documents(folder) == expected
        figures[name + "_pids"] = len({row["worker"] for row in done})
        # Done again: begun twice, or done by the killed worker just before it could say so.
        skipped = sum(row["status"] == "skipped" for row in done)
        figures[name + "_again"] = skipped + sum(count > 1 for count in begun.values())
        same &= figures[name + "_same"]
    restarted, figures["restarted_s"] = timed(lambda: here(rows, out / "alone"))
    same &= all(row["status"] != "done" for row in restarted)
    return figures, same


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--models", type=int, default=200)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--check", action="store_true")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    rows = list(generated(args.models))
    if args.check:
        figures, same = check(rows, args.out.resolve())
        print(json.dumps({"same": same, **figures}))
        sys.exit(not same)
    done = with_ray(args.workers, lambda: by_ray(rows, args.out.resolve(), args.workers))
    for row in done:
        if row["status"] == "failed":
            print(f"{row['name']}: {row['error']}")
    print(dict(Counter(row["status"] for row in done)))
    sys.exit(any(row["status"] == "failed" for row in done))


if __name__ == "__main__":
    main()
