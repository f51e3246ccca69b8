#!/usr/bin/env python3
"""Runs `trunnion prepare` over a folder of models and prints a table: the way that was taken, what it costs, what was refused and why.

    parts.py TRUNNION FOLDER [--machine PROFILE] [--slicer NAME] [--kinds LETTERS] [--only NAME ..] [--out TABLE.tsv]

FOLDER holds the models and parts.tsv beside them, a table with a line a model: file, kind (one letter), tab between them. Without such a table
every model in it is run. Nothing is written into FOLDER.
"""

import argparse
import collections
import csv
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile

MODELS = (".stl", ".3mf", ".obj", ".off")


def rows(folder, kinds):
    table = os.path.join(folder, "parts.tsv")
    if not os.path.exists(table):
        return [(name, "-") for name in sorted(os.listdir(folder)) if name.lower().endswith(MODELS)]
    with open(table, newline="") as file:
        found = [(row["file"], row["kind"]) for row in csv.DictReader(file, delimiter="\t")]
    return [row for row in found if kinds is None or row[1] in kinds]


def run(args, name, folder):
    """One model: exit code, document, CPU seconds, the most memory in MB."""
    words = [args.trunnion, "prepare", os.path.join(args.folder, name), "-m", args.machine, "--slicer", args.slicer]
    words += ["-o", os.path.join(folder, "out.gcode"), "--json"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
        text = child.stdout.read()
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    try:
        document = json.loads(text)
    except ValueError:
        document = {}
    return child.returncode, document, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def told(code, document):
    """The way that was taken and its supports' share of the filament; or why there is no file."""
    ways = document.get("ways", [])
    if code == 0:
        taken = next(way for way in ways if way["chosen"])
        return taken["way"], 100 * taken["support_g"] / max(taken["grams"] - taken["support_g"], 1e-9), ""
    findings = document.get("verify", {}).get("findings", [])
    if findings:
        return "rejected", 0.0, findings[0]["rule"] + ": " + findings[0]["text"]
    return "refused", 0.0, document.get("error") or document.get("summary", "no answer")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trunnion")
    parser.add_argument("folder")
    parser.add_argument("--machine", default="generic-ac")
    parser.add_argument("--slicer", default="builtin")
    parser.add_argument("--kinds")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--out")
    args = parser.parse_args()
    out = open(args.out, "w") if args.out else sys.stdout
    taken, seconds, most = collections.Counter(), [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        print("file", "kind", "exit", "cpu_s", "mb", "way", "support_%", "why not", sep="\t", file=out)
        for name, kind in rows(args.folder, args.kinds):
            if args.only and name.split(".")[0] not in args.only:
                continue
            code, document, cpu, mb = run(args, name, folder)
            way, share, why = told(code, document)
            print(name, kind, code, f"{cpu:.1f}", f"{mb:.0f}", way, f"{share:.1f}", why[:160], sep="\t", file=out, flush=True)
            taken[way] += 1
            seconds.append(cpu)
            most = max(most, mb)
    if seconds:
        counts = ", ".join(f"{count} {way}" for way, count in taken.most_common())
        print(f"{len(seconds)} models: {counts}; median {statistics.median(seconds):.1f} CPU s, worst {max(seconds):.1f}, {most:.0f} MB")


if __name__ == "__main__":
    main()
