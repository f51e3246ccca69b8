"""From arrays to a verified print, with pictures: what a notebook would show, step by step.

    python first_print.py [FOLDER]

A Y of three parts is made of NumPy arrays, its parts are oriented, the whole is planned for a machine, sliced by the built-in slicer and
verified; a T of one solid is cut. FOLDER (default: here) gets what is named below. Lengths are mm, angles degrees.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

import trunnion

Arrays = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]


def box(size: npt.ArrayLike, place: npt.ArrayLike, turned_deg: float = 0.0) -> Arrays:
    """Vertices (8 x 3) and facets (12 x 3) of a box that stands on `place` and is turned about Y."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)]) * np.asarray(size)
    angle = np.radians(turned_deg)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    facets = np.array([corner for a, b, c, d in quads for corner in ((a, b, c), (a, c, d))])
    return corners @ turn.T + np.asarray(place), facets


def drawn_out(outline: Sequence[tuple[float, float]], depth: float, middle: tuple[float, float]) -> Arrays:
    """Vertices and facets of an outline in X and Z (counter-clockwise, all of it seen from `middle`) drawn out along Y."""
    count = len(outline)
    vertices = [(x, y, z) for y in (0.0, depth) for x, z in (*outline, middle)]
    pairs = [(i, (i + 1) % count) for i in range(count)]
    near = [(i, j, count) for i, j in pairs]
    far = [(j + count + 1, i + count + 1, 2 * count + 1) for i, j in pairs]
    sides = [side for i, j in pairs for side in ((i, i + count + 1, j), (j, i + count + 1, j + count + 1))]
    return np.array(vertices), np.array(near + far + sides)


folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

# 1. A model: a post, and two arms that stand on a roof of 45 degrees. Parts that touch share their faces and stay parts.
half = 10.0
roof = [(-half, 0.0), (half, 0.0), (half, 40.0), (0.0, 50.0), (-half, 40.0)]
slope = half * np.sqrt(2.0)
arm = (slope, 2 * half, 30.0)
model = trunnion.Model.from_meshes(
    {
        "post": drawn_out(roof, 2 * half, middle=(0.0, 20.0)),
        "right": box(arm, (half / 2, half, 45.0), 45.0),
        "left": box(arm, (-half / 2, half, 45.0), -45.0),
    },
    name="y.3mf",
)
model.write(folder / "y.3mf")
found = trunnion.inspect(model)
for part in found.parts:
    print(f"{part.name}: {part.facets} facets, {part.volume_mm3:.0f} mm3")
print("touching:", [(one.a, one.b, round(one.area_mm2, 1)) for one in found.interfaces])

# 2. Orientations: of one arm alone, over all directions, by two measures beside each other.
oriented = trunnion.orient(model, parts=[1], objective="support-area", landscape=folder / "landscape.svg")
best = oriented.parts[0].best
print(f"an arm by itself: {best.value:.1f} mm2 need support with {np.round(best.up, 3)} up, {best.kind}")

# 3. A machine and a plan for it: which part in which slot, and at which pose of the table.
machine = trunnion.Profile("generic-ac")
planned = trunnion.plan(model, machine, output=folder / "y.plan.json", sheet=folder / "y.plan.svg")
for slot in planned.slots:
    for one in slot.prints:
        print(f"slot {slot.id}: {found.parts[one.part].name} at A{one.tilt_deg:g} C{one.rotation_deg:g}")

# 4. The print: sliced, rewritten and replayed on the machine's model. Nothing is written that was not proved.


def told(progress: trunnion.Progress) -> None:
    print("  ..", progress.text, f"{progress.done} of {progress.of}" if progress.kind == "step" else "")


done = trunnion.prepare(
    model, machine, slicer="builtin", output=folder / "y.gcode", sheet=folder / "y.png", progress=told
)
print(f"{done.output}: {done.verify.moves} moves, {done.verify.seconds_print / 60:.0f} min, {done.verify.filament_mm / 1000:.2f} m,")
print(f"at least {done.verify.clearance_mm:.2f} mm between the head and what stands")

# 5. One solid that cannot be printed whole: cut into parts that can.
tee = trunnion.Model.from_arrays(
    *drawn_out([(-30, 60), (-30, 40), (-10, 40), (-10, 0), (10, 0), (10, 40), (30, 40), (30, 60)], 20.0, middle=(0, 50)), name="tee"
)
cut = trunnion.split(tee, machine, output=folder / "tee.parts.3mf")
print(f"tee: {len(cut.planes)} cuts, {cut.parts} parts, needs support {cut.needs_support_mm2['before']:.0f} -> {cut.needs_support_mm2['after']:.0f} mm2")

# 6. What cannot be is an exception that says why, and what would help.
try:
    trunnion.plan(tee, machine)
except trunnion.NoPlanError as error:
    print("tee as it is:", error)
    for remedy in error.remedies:
        print("  remedy:", remedy["text"])
