"""What the tests have in common: the command that was built from the same source, models, a folder for each test."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
COMMAND = os.environ.get("TRUNNION", str(ROOT / "target/debug/trunnion"))


def fixture(name):
    return str(ROOT / "fixtures" / f"{name}.stl")


def command(*words, cwd=None):
    """The command's exit code, its document, and what it said."""
    run = subprocess.run([COMMAND, words[0], "--json", *map(str, words[1:])], capture_output=True, text=True, cwd=cwd)
    return run.returncode, json.loads(run.stdout) if run.stdout else None, run.stderr


def untimed(document):
    """Without what a clock says, and with how each list and key is ordered."""
    clock = ("seconds", "seconds_plan", "seconds_reading", "seconds_testing")
    if isinstance(document, dict):
        return [(key, untimed(value)) for key, value in document.items() if key not in clock]
    return [untimed(one) for one in document] if isinstance(document, list) else document


def box(low, high):
    """Vertices and facets of a box."""
    corners = np.array([[(low, high)[(i >> axis) & 1][axis] for axis in range(3)] for i in range(8)], dtype=float)
    facets = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
    return corners, np.array(facets)


def tee():
    """A T of one solid, its outline in X and Z drawn out in Y; its bar hangs on both sides."""
    outline = [(-10, 0), (10, 0), (10, 40), (30, 40), (30, 60), (-30, 60), (-30, 40), (-10, 40)]
    ring = len(outline)
    vertices = np.array([(x, y, z) for y in (-10.0, 10.0) for x, z in outline])
    faces = [(0, 1, 2), (0, 2, 7), (2, 3, 4), (2, 4, 5), (2, 5, 7), (5, 6, 7)]
    near = [list(face) for face in faces]
    far = [[ring + c, ring + b, ring + a] for a, b, c in faces]
    sides = []
    for a in range(ring):
        b = (a + 1) % ring
        sides += [[a, ring + a, b], [b, ring + a, ring + b]]
    return vertices, np.array(near + far + sides)


class Folder(unittest.TestCase):
    maxDiff = 2000

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = Path(kept.name)

    def same(self, ours, theirs):
        self.assertEqual(untimed(ours), untimed(theirs))
