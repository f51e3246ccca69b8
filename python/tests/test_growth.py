"""A thousand calls leave nothing behind: not in Python's memory, not in the process's, no thread and no open file."""

import ctypes
import gc
import os
import subprocess
import sys
import time
import tracemalloc
import unittest
from pathlib import Path

import trunnion
from shared import Folder, box

WARM, ROUNDS, CALLS = 100, 3, 300
#: Of each call, in bytes of the process, and of Python's own objects, where there is no noise. What is kept for good is kept in each round;
#: what the system gives in large pieces, or a thread that ends late, is seen in one of them.
MOST_GROWN, MOST_OBJECTS = 3000, 20
#: How long the threads of the last calls may take to end, s.
ENDING = 60


def small(folder):
    """What is called: each a name and a function of nothing."""
    model = trunnion.Model.from_arrays(*box((0, 0, 0), (4, 4, 0.4)))
    model.write(folder / "small.3mf")
    done = trunnion.prepare(folder / "small.3mf", "generic-ac", slicer="builtin", output=folder / "small.gcode", plan_out=folder / "small.json")
    broken = trunnion.Model("broken.stl", b"solid\n")

    def refused():
        try:
            trunnion.inspect(broken)
        except trunnion.InputError:
            return
        raise AssertionError("a broken model was read")

    def listened():
        seen = []
        trunnion.verify(folder / "small.gcode", folder / "small.json", progress=seen.append)
        return seen

    return {
        "inspect": lambda: trunnion.inspect(model),
        "verify": lambda: trunnion.verify(done),
        "verify, of files and with progress": listened,
        "what is refused": refused,
    }


def resident():
    """Bytes of this process that are in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def counted(kind):
    """How many threads ("task") or open files ("fd") this process has."""
    return len(os.listdir(f"/proc/self/{kind}"))


def grown(call):
    """What a call keeps: bytes of the process and Python's bytes, both the least of several rounds; threads and files of all of them."""

    def state():
        gc.collect()
        # What was freed is given back, so that only what is kept is counted.
        getattr(ctypes.CDLL(None), "malloc_trim", lambda _: 0)(0)
        return resident(), tracemalloc.get_traced_memory()[0]

    for _ in range(WARM):
        call()
    threads, files = counted("task"), counted("fd")
    states = [state()]
    for _ in range(ROUNDS):
        for _ in range(CALLS):
            call()
        states.append(state())
    end = time.monotonic() + ENDING
    while (counted("task") > threads or counted("fd") > files) and time.monotonic() < end:
        time.sleep(0.01)
    process, python = zip(*([(after - before) // CALLS for before, after in zip(*pair)] for pair in zip(states, states[1:])))
    return min(process), min(python), counted("task") - threads, counted("fd") - files


class Growth(Folder):
    def test_a_thousand_calls(self):
        if not Path("/proc/self/statm").exists():
            print("SKIPPED: this system does not say what a process has in memory: calls are not measured", file=sys.stderr)
            self.skipTest("no /proc")
        # A process of its own: what other tests have left is none of these calls'.
        env = {**os.environ, "PYTHONPATH": str(Path(__file__).parent), "RAYON_NUM_THREADS": "2"}
        run = subprocess.run([sys.executable, __file__, str(self.folder)], env=env, capture_output=True, text=True, timeout=1800)
        self.assertEqual(run.returncode, 0, run.stderr)
        rows = [line.split("\t") for line in run.stdout.splitlines()]
        self.assertEqual(len(rows), 4)
        for name, *figures in rows:
            process, python, threads, files = map(int, figures)
            with self.subTest(call=name):
                self.assertLess(process, MOST_GROWN, run.stdout)
                self.assertLess(python, MOST_OBJECTS, run.stdout)
                self.assertLessEqual(threads, 0, run.stdout)
                self.assertLessEqual(files, 0, run.stdout)


def main(folder):
    tracemalloc.start()
    for name, call in small(Path(folder)).items():
        print(name, *grown(call), sep="\t", flush=True)


if __name__ == "__main__":
    main(sys.argv[1]) if len(sys.argv) > 1 else unittest.main()
