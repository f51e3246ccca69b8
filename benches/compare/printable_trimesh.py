#!/usr/bin/env python3
"""Volume, centre of mass, first layer and tipping angle of a part in poses, by numpy and trimesh: a witness for tests.

    printable_trimesh.py MODEL LAYER < directions     at directions (lines of x y z), a JSON list of objects

Lengths are the file's numbers, taken as mm. The volume and the centre of mass are trimesh's own; the footprint is the shadow of what
faces down and lies up to the layer's height (each triangle clipped there), its outline a monotone chain.
"""
import json
import sys

import numpy as np
import trimesh


def chain(points):
    """The convex outline of points (n, 2), counter-clockwise (Andrew)."""
    points = sorted(set(map(tuple, points.round(12))))
    if len(points) < 3:
        return np.array(points)

    def turn(o, a, b):
        return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])

    def half(points):
        kept = []
        for p in points:
            while len(kept) > 1 and turn(kept[-2], kept[-1], p) <= 0.0:
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return np.array(half(points) + half(points[::-1]))


def below(triangle, layer):
    """What of a triangle (3, 3) lies up to a height: a polygon's corners, none of it perhaps."""
    kept = []
    for p, q in zip(triangle, np.roll(triangle, -1, axis=0)):
        if p[2] <= layer:
            kept.append(p)
        if (p[2] <= layer) != (q[2] <= layer):
            kept.append(p + (q - p) * (layer - p[2]) / (q[2] - p[2]))
    return np.array(kept)


def shadow(ring):
    """Twice the signed area of a polygon seen from above."""
    x, y = ring[:, 0], ring[:, 1]
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def pose(mesh, up, layer):
    turned = mesh.copy()
    turned.apply_transform(trimesh.geometry.align_vectors(up, [0.0, 0.0, 1.0]))
    turned.apply_translation([0.0, 0.0, -turned.bounds[0][2]])
    low = turned.triangles[turned.triangles[:, :, 2].min(axis=1) <= layer]
    rings = [ring for ring in (below(triangle, layer) for triangle in low) if len(ring)]
    shadows = [shadow(ring - ring[0]) for ring in rings]
    centre = turned.center_mass
    ring = chain(np.concatenate(rings)[:, :2])
    sides = np.roll(ring, -1, axis=0) - ring
    to = centre[:2] - ring
    reach = ((sides[:, 0] * to[:, 1] - sides[:, 1] * to[:, 0]) / np.linalg.norm(sides, axis=1)).min()
    if reach < 0.0:
        along = np.clip((sides * to).sum(axis=1) / (sides * sides).sum(axis=1), 0.0, 1.0)
        reach = -np.linalg.norm(to - along[:, None] * sides, axis=1).min()
    return {
        "footprint_mm2": -sum(s for s in shadows if s < 0.0) / 2.0,
        "tipping_deg": float(np.degrees(np.arctan2(reach, centre[2]))),
        "height_mm": float(turned.bounds[1][2]),
    }


def main():
    mesh = trimesh.load(sys.argv[1], force="mesh", process=False)
    mesh.merge_vertices()
    ups = np.loadtxt(sys.stdin, ndmin=2)
    poses = [pose(mesh, up / np.linalg.norm(up), float(sys.argv[2])) for up in ups]
    whole = {"volume_mm3": float(mesh.volume), "centre_mm": mesh.center_mass.tolist(), "area_mm2": float(mesh.area)}
    json.dump({**whole, "poses": poses}, sys.stdout)


if __name__ == "__main__":
    main()
