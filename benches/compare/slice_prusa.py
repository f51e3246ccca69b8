"""Processor time of the built-in slicer beside PrusaSlicer's on the same prints, both by `trunnion slice`.

    python slice_prusa.py TRUNNION [FACETS]

TRUNNION is the command. For each shape one line: seconds of processor time (user and system, all threads, the least of three runs) by either
slicer, the quotient, and the most memory of a run, MB. What both have in common, reading plan and model, is in both figures. With FACETS a ball
of so many facets is sliced as well, by the built-in slicer alone. PrusaSlicer is run on one processor, as the command runs it.
"""

import math
import os
import struct
import subprocess
import sys
import tempfile

RUNS = 3


def prism(ring, low, high):
    """A prism over a ring that runs anticlockwise and is seen as a whole from its middle."""
    n = len(ring)
    mid = [sum(p[i] for p in ring) / n for i in (0, 1)]
    out = []
    for i in range(n):
        a, b = ring[i], ring[(i + 1) % n]
        out += [((*a, low), (*b, low), (*b, high)), ((*a, low), (*b, high), (*a, high))]
        out += [((*b, low), (*a, low), (*mid, low)), ((*a, high), (*b, high), (*mid, high))]
    return out


def skin(profile, sides):
    """The surface of a body of revolution; `profile` goes from the axis below to the axis above, as (radius, height)."""
    out = []
    for (r0, z0), (r1, z1) in zip(profile, profile[1:]):
        for i in range(sides):
            a, b = (2 * math.pi * (k % sides) / sides for k in (i, i + 1))
            at = lambda r, z, t: (r * math.cos(t), r * math.sin(t), z)
            p, q, s, t = at(r0, z0, a), at(r0, z0, b), at(r1, z1, b), at(r1, z1, a)
            out += [f for f in ((p, q, s), (p, s, t)) if len(set(f)) == 3 and (r0 or r1)]
    return [f for f in out if len({tuple(round(v, 9) for v in p) for p in f}) == 3]


def ball(radius, rings):
    profile = [(radius * math.sin(math.pi * k / rings), radius - radius * math.cos(math.pi * k / rings)) for k in range(rings + 1)]
    profile[0], profile[-1] = (0.0, 0.0), (0.0, 2 * radius)
    return skin(profile, 2 * rings)


def polar(count, radius):
    return [(radius(k) * math.cos(2 * math.pi * k / count), radius(k) * math.sin(2 * math.pi * k / count)) for k in range(count)]


def square(x0, y0, x1, y1):
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def shapes():
    """Names, and what makes each mesh."""
    for name, mesh in simple():
        yield name, lambda mesh=mesh: mesh


def simple():
    yield "cube", prism(square(-10, -10, 10, 10), 0, 20)
    yield "cylinder", prism(polar(96, lambda _: 10), 0, 20)
    yield "cone", skin([(0, 0), (12, 0), (0, 24)], 96)
    yield "ball", ball(12, 48)
    yield "gear", prism(polar(80, lambda k: 14 if k % 4 < 2 else 11), 0, 8)
    yield "star", prism(polar(14, lambda k: 15 if k % 2 == 0 else 6), 0, 8)
    for degrees in (5, 20):
        half = 16 * math.tan(math.radians(degrees) / 2)
        yield f"wedge {degrees}", prism([(-8, 0), (8, -half), (8, half)], 0, 4)
    for thick in (0.4, 0.8, 1.6, 3.0):
        yield f"wall {thick}", prism(square(-10, -thick / 2, 10, thick / 2), 0, 6)
    yield "pins", [f for i in range(8) for j in range(8) for f in prism([(x + 4 * i, y + 4 * j) for x, y in polar(16, lambda _: 1.2)], 0, 8)]
    yield "fins", [f for i in range(10) for f in prism(square(-10, 2 * i - 10, 10, 2 * i - 9.2), 0, 8)]
    yield "plate", prism(square(-60, -60, 60, 60), 0, 2)


def stl(path, facets):
    with open(path, "wb") as file:
        file.write(b"\0" * 80 + struct.pack("<I", len(facets)))
        for f in facets:
            file.write(struct.pack("<12fH", 0, 0, 0, *(v for p in f for v in p), 0))


def run(command):
    """Processor seconds of a command and of all that it starts, and the most memory of its largest process, MB."""
    pid = os.spawnvp(os.P_NOWAIT, "sh", ["sh", "-c", "exec >/dev/null 2>/dev/null; " + command])
    _, status, used = os.wait4(pid, 0)
    return (used.ru_utime + used.ru_stime, used.ru_maxrss / 1024) if status == 0 else None


def main():
    trunnion, facets = os.path.abspath(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        print(f"{'shape':12}{'built-in s':>12}{'PrusaSlicer s':>15}{'share':>8}{'MB':>7}")
        all_shapes = list(shapes())
        if facets:
            all_shapes.append((f"{facets}", lambda: ball(40, max(int(math.sqrt(facets / 4)), 3))))
        for name, mesh in all_shapes:
            # In a process of its own: what is started by a large one counts its memory, too.
            child = os.fork()
            if child == 0:
                stl("model.stl", mesh())
                os._exit(0)
            os.waitpid(child, 0)
            made = subprocess.run([trunnion, "plan", "model.stl", "-m", "generic-ac", "--allow", "0", "--overhang", "89", "-o", "plan.json"], capture_output=True, text=True)
            if made.returncode:
                print(f"{name:12}no plan: {made.stderr.strip().splitlines()[-1]}")
                continue
            slice_by = lambda slicer: f"{trunnion} slice plan.json --slicer {slicer} -o slots"
            slicers = ["builtin"] if name == str(facets) else ["builtin", "prusa-slicer"]
            best = [min(filter(None, (run(slice_by(slicer)) for _ in range(RUNS))), default=None) for slicer in slicers]
            ours, theirs = best[0], best[1] if len(best) > 1 else None
            if ours is None:
                print(f"{name:12}is refused by the built-in slicer")
            elif theirs is None:
                print(f"{name:12}{ours[0]:12.3f}{'-':>15}{'-':>8}{ours[1]:7.0f}")
            else:
                print(f"{name:12}{ours[0]:12.3f}{theirs[0]:15.3f}{ours[0] / theirs[0]:8.2f}{ours[1]:7.0f}")


main()
