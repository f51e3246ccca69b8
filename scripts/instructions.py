#!/usr/bin/env python3
"""Instructions of ten fixed jobs, compared with the counts that are kept beside this script.

    scripts/instructions.py                     count and compare; a job with 3 % more than its count is reported, with exit code 1
    scripts/instructions.py --write             keep what was counted
    scripts/instructions.py --program FILE      another program than the development build
    scripts/instructions.py verify-y-tree ..    these jobs alone

Seconds differ from run to run on a shared machine, instructions by some 0.1 %. Everything runs on one thread. Counts of a release build, or of
another compiler, are other counts: they are kept by the profile that the program was built with, and compared with their own alone.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KEPT = Path(__file__).with_suffix(".json")
MORE = 0.03

MACHINE = ["-m", "generic-ac"]
PREPARE = MACHINE + ["--slicer", "builtin", "-q"]
# By name: the fixture, words of `prepare` that make what the job needs (none: nothing is made), and the job. {model}, {plan}, {made} and {out}
# are files.
JOBS = {
    "inspect-candelabrum": ("candelabrum", None, ["inspect", "{model}"]),
    "orient-ding": ("ding", None, ["orient", "{model}", "-q"]),
    "plan-candelabrum": ("candelabrum", None, ["plan", "{model}", *MACHINE, "-o", "{out}.json", "-q"]),
    "prepare-cube": ("cube", None, ["prepare", "{model}", *PREPARE, "-o", "{out}.gcode"]),
    "prepare-two-boxes": ("two-boxes", None, ["prepare", "{model}", *PREPARE, "-o", "{out}.gcode"]),
    "verify-two-boxes": ("two-boxes", [], ["verify", "{made}", "--plan", "{plan}", "-q"]),
    "verify-y-tree": ("y-tree", [], ["verify", "{made}", "--plan", "{plan}", "-q"]),
    "verify-ding": ("ding", [], ["verify", "{made}", "--plan", "{plan}", "-q"]),
    "verify-hook": ("hook", ["--way", "supports"], ["verify", "{made}", "--plan", "{plan}", "-q"]),
    "preview-two-boxes": ("two-boxes", [], ["preview", "{made}", "--plan", "{plan}", "-o", "{out}.html", "-q"]),
}


def run(words: list[str], folder: Path) -> subprocess.CompletedProcess:
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, env={**os.environ, "RAYON_NUM_THREADS": "1"})
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)}\nended with {done.returncode}:\n{done.stderr}")
    return done


def count(program: Path, name: str) -> int:
    """The instructions of one job."""
    fixture, more, job = JOBS[name]
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        places = {"model": ROOT / "fixtures" / f"{fixture}.stl", "plan": folder / "plan.json", "made": folder / "made.gcode", "out": folder / "out"}
        if more is not None:
            run([str(program), "prepare", str(places["model"]), *PREPARE, *more, "-o", str(places["made"]), "--plan-out", str(places["plan"])], folder)
        words = [word.format(**places) for word in job]
        told = run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder / 'counts'}", str(program), *words], folder)
    found = re.search(r"Collected : (\d+)", told.stderr)
    if not found:
        sys.exit(f"callgrind counted nothing:\n{told.stderr}")
    return int(found[1])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("jobs", nargs="*", choices=[[], *JOBS], help="jobs to count; all of them without any")
    parser.add_argument("--program", type=Path, help="the program; else the development build")
    parser.add_argument("--profile", default="dev", help="what it was built with: dev or release")
    parser.add_argument("--write", action="store_true", help="keep the counts")
    args = parser.parse_args()
    if not shutil.which("valgrind"):
        print("SKIPPED: valgrind is not installed, so no instructions were counted")
        return 0
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = (args.program or target / "debug" / "trunnion").resolve()
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    known = kept.setdefault(args.profile, {})
    grown = 0
    for name in args.jobs or JOBS:
        now, before = count(program, name), known.get(name)
        change = now / before - 1.0 if before else 0.0
        grown += change > MORE
        word = "new" if before is None else f"{change:+.1%}" + (f", more than {MORE:.0%}" if change > MORE else "")
        print(f"{name:22} {now / 1e6:10.1f} million instructions, {word}", flush=True)
        if args.write:
            known[name] = now
    if args.write:
        KEPT.write_text(json.dumps(kept, indent=2) + "\n")
    return int(grown > 0 and not args.write)


if __name__ == "__main__":
    sys.exit(main())
