#!/usr/bin/env python3
"""What proof costs beside reading: processor time of verify, preview and rewrite for each finished file, as a ratio to md5 of the same bytes.

    scripts/ratios.py                     twelve files, made here: fixtures, an enclosure, fluted tubes
    scripts/ratios.py --program FILE      another program than the release build
    scripts/ratios.py y-tree tube-7 ..    these files alone

Everything runs on one thread but the last column: wall time on one thread over that on two. Each is the best of three. md5 is Python's hashlib
(OpenSSL), repeated until it takes half a second.
"""

import argparse
import hashlib
import math
import os
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PREPARE = ["-m", "generic-ac", "--slicer", "builtin", "-q"]


def fluted(height: float):
    """A tube with 24 flutes, 3 mm thick, of 720 corners a ring: facets of its surface."""
    count = 720

    def ring(radius, deep, z):
        places = []
        for k in range(count):
            turn = 2 * math.pi * k / count
            r = radius + deep * math.cos(24 * turn)
            places.append((r * math.cos(turn), r * math.sin(turn), z))
        return places

    outer, inner = [ring(24, 1.2, z) for z in (0, height)], [ring(21, 1.2, z) for z in (0, height)]
    for k in range(count):
        n = (k + 1) % count
        for low, high in ((outer[0], outer[1]), (inner[1], inner[0])):
            yield low[k], low[n], high[n]
            yield low[k], high[n], high[k]
        for one, other in ((inner[0], outer[0]), (outer[1], inner[1])):
            yield one[k], one[n], other[n]
            yield one[k], other[n], other[k]


def enclosure():
    """A box of 80 x 60 x 30 mm, open above, with walls and a floor of 3 mm."""
    outline = [(0, 0), (80, 0), (80, 60), (0, 60)]
    inside = [(3, 3), (77, 3), (77, 57), (3, 57)]
    up = lambda places, z: [(x, y, z) for x, y in places]
    low, top, rim, floor = up(outline, 0), up(outline, 30), up(inside, 30), up(inside, 3)
    yield from ((low[0], low[2], low[1]), (low[0], low[3], low[2]), (floor[0], floor[1], floor[2]), (floor[0], floor[2], floor[3]))
    for k in range(4):
        n = (k + 1) % 4
        for a, b, c, d in ((low[k], low[n], top[n], top[k]), (top[k], top[n], rim[n], rim[k]), (rim[k], rim[n], floor[n], floor[k])):
            yield a, b, c
            yield a, c, d


def write(facets, path: Path):
    facets = list(facets)
    with open(path, "wb") as out:
        out.write(b"\0" * 80 + struct.pack("<I", len(facets)))
        for corners in facets:
            out.write(struct.pack("<3f", 0, 0, 0) + b"".join(struct.pack("<3f", *corner) for corner in corners) + b"\0\0")


# By name: how the model is made (none: a fixture of that name), and words of `prepare`.
FILES = {
    "cube": (None, []),
    "bracket": (None, []),
    "two-boxes": (None, []),
    "y-tree": (None, []),
    "ding": (None, []),
    "hook": (None, ["--way", "supports"]),
    "candelabrum": (None, []),
    "under-the-gantry": (None, []),
    "enclosure": (enclosure, ["--way", "as-drawn"]),
    "tube-7": (lambda: fluted(8), ["--way", "as-drawn"]),
    "tube-27": (lambda: fluted(30), ["--way", "as-drawn"]),
    "tube-109": (lambda: fluted(120), ["--way", "as-drawn"]),
}


def run(words, threads=1):
    """Processor seconds, wall seconds, and the most memory in bytes, of the best of three runs."""
    best = None
    for _ in range(3):
        begun = time.monotonic()
        process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env={**os.environ, "RAYON_NUM_THREADS": str(threads)})
        said = process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        if status:
            sys.exit(f"{' '.join(map(str, words))}\n{said.decode()}")
        one = (used.ru_utime + used.ru_stime, time.monotonic() - begun, used.ru_maxrss * 1024)
        best = one if best is None or one < best else best
    return best


def md5(data: bytes) -> float:
    begun, count = time.process_time(), 0
    while time.process_time() - begun < 0.5:
        hashlib.md5(data, usedforsecurity=False).digest()
        count += 1
    return (time.process_time() - begun) / count


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", choices=[[], *FILES], help="files to look at; all of them without any")
    parser.add_argument("--program", type=Path, help="the program; else the release build")
    args = parser.parse_args()
    program = (args.program or Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "trunnion").resolve()
    print("| file | MB | lines | md5, ms | verify | preview | rewrite | memory, bytes a byte | two threads |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in args.files or FILES:
        make, more = FILES[name]
        with tempfile.TemporaryDirectory() as made:
            folder = Path(made)
            model, whole, plan = ROOT / "fixtures" / f"{name}.stl", folder / "whole.gcode", folder / "plan.json"
            if make:
                model = folder / f"{name}.stl"
                write(make(), model)
            words = [program, "prepare", model, *PREPARE, *more, "-o", whole, "--plan-out", plan]
            done = subprocess.run(words, capture_output=True, text=True)
            if done.returncode:
                print(f"| {name} | not printed: {done.stderr.strip().splitlines()[-1]} |")
                continue
            data = whole.read_bytes()
            reading = md5(data)
            verify = run([program, "verify", whole, "--plan", plan, "-q"])
            preview = run([program, "preview", whole, "--plan", plan, "-o", folder / "page.html", "-q"])
            slices = folder / "slices"
            subprocess.run([program, "slice", plan, "--slicer", "builtin", "-o", slices, "-q"], check=True, capture_output=True)
            rewrite = run([program, "rewrite", *sorted(slices.glob("*.gcode")), "--plan", plan, "-o", folder / "again.gcode", "-q"])
            two = run([program, "verify", whole, "--plan", plan, "-q"], 2)
            ratios = " | ".join(f"{one[0] / reading:.0f}" for one in (verify, preview, rewrite))
            memory, faster = verify[2] / len(data), verify[1] / two[1]
            lines = data.count(b"\n")
            print(f"| {name} | {len(data) / 1e6:.1f} | {lines} | {1000 * reading:.1f} | {ratios} | {memory:.1f} | {faster:.2f} |", flush=True)


if __name__ == "__main__":
    main()
