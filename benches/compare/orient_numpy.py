#!/usr/bin/env python3
"""The objectives of `trunnion orient` in plain numpy, and what a numpy user would do to minimise them, beside the command.

    orient_numpy.py values MODEL < directions        values at directions (lines of x y z), as JSON: a witness for tests
    orient_numpy.py compare MODEL --trunnion PATH     CPU seconds on one thread and values, beside `trunnion orient`

Lengths are in the file's own numbers, taken as mm; directions `d` are unit and point up while printing. The formulas are
typed from seeds 000 (overhang-angle, normal-z, weighted-normal-z), 001 (tanh-overhang), 002 (support-volume-convex) and
004 (staircase, support-area, height), vectorised over facets and directions; nothing is shared with the command. A numpy user's
search is a grid over the two angles (0.5 degrees), then a pattern search from its best point: no proof, and
dips at facet normals are missed.

`normals` is the method that orienting tools use, written anew from its idea alone (candidates are the facet normals that
gather most area, and directions at right angles to long edges; each is judged by overhang and bed area).
"""
import argparse
import json
import os
import subprocess
import sys
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np  # noqa: E402

# As the command's defaults: layer in mm, overhang from the vertical, the paper's tenth, 0.1 degree is flat.
LAYER, OVERHANG, TENTH, FLAT = 0.2, np.radians(45.0), 0.1, 1.0 - 1.5e-6
# Facets times directions worked on at once: 8 MB of doubles.
AT_ONCE = 1 << 20


def read(path):
    """Corners (n, 3) and facets (m, 3) of an STL, OBJ or OFF file; polygons are fanned from their first corner."""
    with open(path, "rb") as file:
        data = file.read()
    ending = os.path.splitext(path)[1].lower()
    if ending == ".stl":
        return read_stl(data)
    lines = [line.split("#")[0].split() for line in data.decode("ascii", "replace").splitlines()]
    lines = [line for line in lines if line]
    if ending == ".obj":
        corners = [line[1:4] for line in lines if line[0] == "v"]
        index = lambda word: int(word.split("/")[0])
        rings = [[index(w) for w in line[1:]] for line in lines if line[0] == "f"]
        rings = [[i - 1 if i > 0 else i + len(corners) for i in ring] for ring in rings]
    elif ending == ".off":
        words = lines[0][1:] or lines[1]
        start = 1 if lines[0][1:] else 2
        count = int(words[0])
        corners = [line[:3] for line in lines[start : start + count]]
        rings = [[int(w) for w in line[1 : 1 + int(line[0])]] for line in lines[start + count :]][: int(words[1])]
    else:
        sys.exit(f"{path}: stl, obj or off is read")
    facets = [(ring[0], ring[k], ring[k + 1]) for ring in rings for k in range(1, len(ring) - 1)]
    # The command reads OBJ in single precision, as its reader does.
    precision = np.float32 if ending == ".obj" else float
    return np.array(corners, dtype=precision).astype(float), np.array(facets, dtype=int)


def read_stl(data):
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
        corners = np.frombuffer(data, record, count, 84)["corners"].astype(float).reshape(-1, 3)
    else:
        words = [line.split()[1:4] for line in data.decode("ascii").splitlines() if line.split()[:1] == ["vertex"]]
        corners = np.array(words, dtype=float)
    points, index = np.unique(corners, axis=0, return_inverse=True)
    return points, index.reshape(-1, 3)


class Part:
    def __init__(self, path):
        self.points, facets = read(path)
        a, b, c = (self.points[facets[:, k]] for k in range(3))
        cross = np.cross(b - a, c - a) / 2.0
        areas = np.linalg.norm(cross, axis=1)
        some = areas > 0.0
        self.corners = np.stack([a, b, c], 1)[some]
        self.areas, self.normals = areas[some], cross[some] / areas[some, None]
        self.middles = self.corners.mean(axis=1)


def low(part, d):
    return (part.points @ d).min(axis=0)


def staircase(part, d):
    along = np.abs(part.normals @ d)
    return LAYER**2 / 2.0 * (part.areas[:, None] * np.where(along >= FLAT, 0.0, along)).sum(axis=0)


def support_area(part, d):
    along = part.normals @ d
    return (part.areas[:, None] * np.where((along < 0.0) & (along > -FLAT), -along, 0.0)).sum(axis=0)


def height(part, d):
    along = part.points @ d
    return along.max(axis=0) - along.min(axis=0)


def overhang_angle(part, d):
    along = np.clip(part.normals @ d, -1.0, 1.0)
    return np.maximum(np.abs(np.arccos(along) - np.pi / 2.0) - OVERHANG, 0.0).sum(axis=0)


def normal_z(part, d):
    return ((part.normals @ d) ** 2).sum(axis=0)


def weighted_normal_z(part, d):
    return (part.areas[:, None] * (part.middles @ d - low(part, d)) * (part.normals @ d) ** 2).sum(axis=0)


def tanh_overhang(part, d):
    s = -2.0 * part.areas[:, None] * (part.normals @ d)
    lift = TENTH * (part.corners.sum(axis=1) @ d - 3.0 * low(part, d))
    return 0.25 * (np.abs(s) * (1.0 + np.tanh(s)) * np.tanh(lift)).sum(axis=0)


def support_volume_convex(part, d):
    along = part.normals @ d
    column = -part.areas[:, None] * along * (part.middles @ d - low(part, d))
    return np.where(-along > np.sin(OVERHANG), column, 0.0).sum(axis=0)


OBJECTIVES = {
    "staircase": staircase,
    "support-area": support_area,
    "height": height,
    "overhang-angle": overhang_angle,
    "normal-z": normal_z,
    "weighted-normal-z": weighted_normal_z,
    "tanh-overhang": tanh_overhang,
    "support-volume-convex": support_volume_convex,
}


def directions(alpha, beta):
    """`d` of the documents' angles (radians), as columns."""
    return np.stack([-np.sin(beta), np.cos(beta) * np.sin(alpha), np.cos(beta) * np.cos(alpha)])


def values(f, part, d):
    step = max(1, AT_ONCE // max(len(part.areas), len(part.points)))
    return np.concatenate([f(part, d[:, i : i + step]) for i in range(0, d.shape[1], step)])


def search(f, part, step_deg):
    """The best of a grid, then of the eight places around it at ever smaller steps: value and direction."""
    alpha, beta = np.meshgrid(np.arange(-180.0, 180.0, step_deg), np.arange(-90.0, 90.0 + step_deg / 2, step_deg))
    alpha, beta = np.radians(alpha.ravel()), np.radians(beta.ravel())
    all_values = values(f, part, directions(alpha, beta))
    i = all_values.argmin()
    at, best, step = np.array([alpha[i], beta[i]]), all_values[i], np.radians(step_deg) / 2.0
    around = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j], dtype=float)
    while step > 1e-8:
        tries = at + around * step
        found = values(f, part, directions(tries[:, 0], tries[:, 1]))
        i = found.argmin()
        if found[i] < best:
            at, best = tries[i], found[i]
        else:
            step /= 2.0
    return float(best), directions(*at).tolist()


def normals(part, candidates=24):
    """The best of the candidates by overhang against bed area: direction."""
    keys, which = np.unique(np.round(part.normals, 3), axis=0, return_inverse=True)
    sums = np.bincount(which.ravel(), part.areas)
    faces = keys[np.argsort(-sums)[:candidates]]
    sides = part.corners - np.roll(part.corners, 1, axis=1)
    lengths = np.linalg.norm(sides, axis=2)
    longest = np.take_along_axis(sides, lengths.argmax(axis=1)[:, None, None], axis=1)[:, 0]
    across = np.cross(part.normals, longest / lengths.max(axis=1)[:, None])
    keys, which = np.unique(np.round(across, 3), axis=0, return_inverse=True)
    edges = keys[np.argsort(-np.bincount(which.ravel(), part.areas))[:candidates]]
    all_of_them = np.concatenate([-faces, faces, edges, -edges])
    d = (all_of_them / np.linalg.norm(all_of_them, axis=1)[:, None]).T
    # Relative to the part: the numbers of such tools are for mm.
    near, some = 1e-3 * np.ptp(part.points, axis=0).max(), 1e-2 * part.areas.sum()
    costs = []
    for k in range(d.shape[1]):
        along, bed = part.normals @ d[:, k], low(part, d[:, k])
        heights = part.corners @ d[:, k] - bed
        lies = (along < -0.999) & (heights.max(axis=1) < near)
        hangs = (along < -np.sin(OVERHANG)) & ~lies
        overhang = (part.areas * -along)[hangs].sum()
        costs.append(overhang / (some + part.areas[lies].sum()))
    return d[:, int(np.argmin(costs))].tolist()


def cpu(work):
    start = time.process_time()
    answer = work()
    return answer, time.process_time() - start


def ask(trunnion, model, arguments):
    """The command's first result, CPU seconds of the whole process, and the seconds after reading that it states."""
    before = os.times()
    command = [trunnion, "orient", model, "--unit", "mm", "--json", "--whole", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    after = os.times()
    if done.returncode != 0:
        return None
    seconds = after.children_user + after.children_system - before.children_user - before.children_system
    return json.loads(done.stdout)["parts"][0]["results"][0], seconds


def compare(arguments):
    (part, reading) = cpu(lambda: Part(arguments.model))
    print(f"{arguments.model}: {len(part.areas)} facets; numpy reads it in {reading:.2f} s; CPU seconds, one thread")
    print(f"{'objective':24}{'numpy s':>9}{'ours s':>9}{'search s':>9}{'ratio':>7}  numpy's best / ours - 1   same place")
    for name in arguments.objective or OBJECTIVES:
        f = OBJECTIVES[name]
        (best, up), spent = cpu(lambda: search(f, part, arguments.step))
        answer = ask(arguments.trunnion, arguments.model, ["--objective", name])
        if answer is None:
            print(f"{name:24}{spent:9.2f}    the command refuses this mesh")
            continue
        result, ours = answer
        least, there = result["minima"][0]["value"], np.array(result["minima"][0]["up"])
        agree = float(f(part, there[:, None])[0])
        print(
            f"{name:24}{spent:9.2f}{ours:9.2f}{result['seconds']:9.3f}{(reading + spent) / max(ours, 1e-3):7.1f}"
            f"  {best / least - 1 if least else best:+.3e}               {abs(agree - least) / max(abs(least), 1e-300):.1e}"
        )
    up, spent = cpu(lambda: normals(part))
    print(f"candidates by area and overhang: {spent:.2f} s, up {np.round(up, 5).tolist()}")
    there = float(support_volume_convex(part, np.array(up)[:, None])[0])
    answer = ask(arguments.trunnion, arguments.model, ["--objective", "support-volume-convex"])
    least = f"{answer[0]['minima'][0]['value']:.6g} by us in {answer[1]:.2f} s" if answer else "not ours to say (open)"
    print(f"support-volume-convex there: {there:.6g}; least: {least}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["values", "compare"])
    parser.add_argument("model")
    parser.add_argument("--trunnion", default="trunnion", help="the command")
    parser.add_argument("--step", type=float, default=0.5, help="the grid's step, degrees")
    parser.add_argument("--objective", action="append", choices=list(OBJECTIVES), help="instead of all")
    arguments = parser.parse_args()
    if arguments.what == "compare":
        return compare(arguments)
    part = Part(arguments.model)
    d = np.loadtxt(sys.stdin, ndmin=2).T
    print(json.dumps({name: values(f, part, d).tolist() for name, f in OBJECTIVES.items()}))


if __name__ == "__main__":
    main()
