"""What type checkers find: the package is typed whole, the example is right by it, and what is wrong is told."""

import json
import shutil
import subprocess
import sys
import unittest
from importlib.util import find_spec
from pathlib import Path

import trunnion
from shared import ROOT, Folder

EXAMPLE = ROOT / "python/examples/first_print.py"

#: What the checkers must know, each with its type.
KNOWN = """
import numpy as np
import trunnion

vertices, facets = np.zeros((8, 3)), np.zeros((12, 3), dtype=np.int64)
model = trunnion.Model.from_arrays(vertices, facets)
reveal_type(trunnion.inspect(model).parts[0].volume_mm3)  # float
reveal_type(trunnion.plan(model, "generic-ac").prints[0].tilt_deg)  # float
reveal_type(trunnion.prepare(model, "generic-ac").gcode)  # bytes
reveal_type(trunnion.support(model).supports_stl)  # bytes | None
reveal_type(trunnion.pack([(model, 2)], space_mm=(9, 9, 9)).plates[0].items[0].copy)  # int
reveal_type(trunnion.preview(model, profile="generic-ac").html)  # str
reveal_type(trunnion.send("x.gcode", dry_run=True, plan="x.json").clean)  # bool
reveal_type(trunnion.send("x.gcode", port="/dev/ttyUSB0", plan="x.json").resends)  # int
reveal_type(trunnion.publish("x.gcode", to="octoprint:http://x").stated.layers)  # int | None
reveal_type(trunnion.verify("x.gcode", "x.json").findings[0].line)  # int
"""

#: What they must refuse, a line each.
WRONG = """
import trunnion

trunnion.inspect("x.stl").volume
trunnion.plan("x.stl")
trunnion.prepare("x.stl", "generic-ac", slicer=3)
trunnion.pack("x.stl", space_mm="9,9,9", turn=90)
trunnion.send("x.gcode", plan="x.json")
trunnion.send("x.gcode", plan="x.json", dry_run=True).resends
trunnion.publish("x.gcode", to=3)
trunnion.preview("x.stl", profile=None, compare="x")["html"]
"""


def left_out(why):
    """A test that cannot be made here says so aloud: the test command lists it."""
    print(f"SKIPPED: {why}", file=sys.stderr, flush=True)
    raise unittest.SkipTest(why)


class Checked(Folder):
    def files(self):
        known, wrong = self.folder / "known.py", self.folder / "wrong.py"
        known.write_text(KNOWN)
        wrong.write_text(WRONG)
        return known, wrong

    def test_mypy(self):
        if not find_spec("mypy"):
            left_out("mypy is not installed: it does not check the Python package")
        known, wrong = self.files()

        def mypy(*words):
            command = [sys.executable, "-m", "mypy", "--cache-dir", self.folder / "cache", "--no-error-summary", *words]
            return subprocess.run(list(map(str, command)), capture_output=True, text=True, cwd=self.folder)

        # Its source: of what is installed mypy says nothing.
        for words in (["--strict", ROOT / "python/trunnion"], ["--strict", EXAMPLE], ["--strict", known]):
            run = mypy(*words)
            said = [line for line in run.stdout.splitlines() if "note: Revealed type" not in line]
            self.assertEqual((run.returncode, said), (0, []), run.stdout + run.stderr)
        types = [line.split('"')[1].replace("builtins.", "") for line in run.stdout.splitlines()]
        self.assertEqual(types, [line.split("# ")[1] for line in KNOWN.splitlines() if "# " in line])
        run = mypy(wrong)
        self.assertEqual({int(line.split(":")[1]) for line in run.stdout.splitlines() if ": error:" in line}, set(range(4, 12)), run.stdout)

    def test_pyright(self):
        if not find_spec("pyright"):
            left_out("pyright is not installed: it does not check the Python package")
        known, wrong = self.files()

        shutil.copy(EXAMPLE, self.folder / "example.py")
        shutil.copytree(Path(trunnion.__file__).parent, self.folder / "trunnion", ignore=shutil.ignore_patterns("__pycache__"))

        def told(strict, *names):
            settings = {"include": list(names), "typeCheckingMode": "strict" if strict else "standard"}
            self.folder.joinpath("pyrightconfig.json").write_text(json.dumps(settings))
            command = [sys.executable, "-m", "pyright", "--outputjson", "--pythonpath", sys.executable]
            run = subprocess.run(command, capture_output=True, text=True, cwd=self.folder)
            if not run.stdout.lstrip().startswith("{"):
                left_out("pyright does not start here: it does not check the Python package")
            return json.loads(run.stdout)["generalDiagnostics"]

        self.assertEqual(told(False, "example.py", "trunnion"), [])
        types = [one["message"] for one in told(True, "known.py")]
        self.assertEqual(len(types), KNOWN.count("reveal_type"), types)
        self.assertEqual([one.split('"')[-2] for one in types], [line.split("# ")[1] for line in KNOWN.splitlines() if "# " in line])
        lines = {one["range"]["start"]["line"] + 1 for one in told(False, "wrong.py") if one["severity"] == "error"}
        self.assertEqual(lines, set(range(4, 12)))


if __name__ == "__main__":
    unittest.main()
