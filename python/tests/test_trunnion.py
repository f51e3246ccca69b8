"""The package beside the command: the same documents, the same bytes; and what Python adds: arrays, callbacks, Ctrl-C, pickles.

Run as ``python -m unittest discover python/tests`` with the package installed; TRUNNION names the command that was built from the same
source.
"""

import json
import logging
import multiprocessing
import os
import pickle
import signal
import subprocess
import threading
import time
import unittest
import warnings
from pathlib import Path

import numpy as np

import trunnion
from shared import COMMAND, Folder, box, command, fixture, tee, untimed


class Documents(Folder):
    def test_inspect(self):
        for name in ["y-tree", "two-boxes", "candelabrum"]:
            code, document, _ = command("inspect", fixture(name))
            done = trunnion.inspect(fixture(name))
            self.assertEqual((code, done.to_dict()), (0, document))
            self.assertEqual([part.volume_mm3 for part in done.parts], [part["volume_mm3"] for part in document["parts"]])
            self.assertEqual(json.loads(done.to_json()), document)

    def test_the_text_of_a_document_is_the_commands_to_the_byte(self):
        run = subprocess.run([COMMAND, "inspect", fixture("y-tree"), "--json"], capture_output=True, text=True)
        self.assertEqual(trunnion.inspect(fixture("y-tree")).to_json() + "\n", run.stdout)

    def test_orient(self):
        model = fixture("hook")
        cases = [
            ({}, []),
            ({"objective": ["staircase", "0.7*height+0.3*support-area"], "compare": True, "overhang_deg": 30, "layer_mm": 0.1},
             ["--objective", "staircase", "--objective", "0.7*height+0.3*support-area", "--compare", "--overhang", "30", "--layer", "0.1"]),
            ({"objective": "staircase", "method": "multistart", "seed": 7, "budget": 500, "whole": True},
             ["--objective", "staircase", "--method", "multistart", "--seed", "7", "--budget", "500", "--whole"]),
            ({"profile": "fibr3d", "up": (0, 1, 1), "contact_area_min_mm2": 2.5, "resolution_mm": 1},
             ["-m", "fibr3d", "--up", "0,1,1", "--contact-area-min", "2.5", "--resolution", "1"]),
            ({"objective": "support-volume", "smooth_k": 8, "smooth_w": 9, "carrying_deg": 30},
             ["--objective", "support-volume", "--smooth-k", "8", "--smooth-w", "9", "--carrying", "30"]),
        ]  # fmt: skip
        for keywords, flags in cases:
            with self.subTest(flags=flags):
                code, document, said = command("orient", model, *flags)
                self.assertEqual(code, 0, said)
                self.same(trunnion.orient(model, **keywords).to_dict(), document)

    def test_orient_of_some_parts_and_its_files(self):
        ours, theirs = self.folder / "ours.stl", self.folder / "theirs.stl"
        done = trunnion.orient(fixture("y-tree"), parts=[0, 2], objective="staircase", output=ours)
        _, document, _ = command("orient", fixture("y-tree"), "--part", "0,2", "--objective", "staircase", "-o", theirs)
        self.same(done.to_dict(), document)
        self.assertEqual([part.id for part in done.parts], [0, 2])
        self.assertEqual(ours.read_bytes(), theirs.read_bytes())
        trunnion.orient(fixture("hook"), objective="staircase", view=self.folder / "ours.svg")
        command("orient", fixture("hook"), "--objective", "staircase", "--view", self.folder / "theirs.svg")
        self.assertEqual((self.folder / "ours.svg").read_bytes(), (self.folder / "theirs.svg").read_bytes())

    def test_plan(self):
        cases = [
            ("two-boxes", {}, []),
            ("candelabrum", {"slots": "single", "margin_mm": 1, "seed": 3}, ["--slots", "single", "--margin", "1", "--seed", "3"]),
            ("y-tree", {"objective": "time", "top": 2, "origin_mm": (5, -3), "turn_deg": 30, "table_later": True},
             ["--objective", "time", "--top", "2", "--origin", "5,-3", "--turn", "30", "--table-later"]),
            ("y-tree", {"order": "0,2,1"}, ["--order", "0,2,1"]),
            ("two-boxes", {"beside": [(fixture("cube"), 2)], "gap_mm": 30}, ["--gap", "30", "--", fixture("cube") + "*2"]),
            ("y-tree", {"allow": {1: 40, 2: None}, "bridge_mm": 4, "tolerate_mm2": 2, "orient_by": "height", "orient_budget": 300},
             ["--allow", "1:40", "--allow", "2", "--bridge", "4", "--tolerate", "2", "--orient-by", "height", "--orient-budget", "300"]),
        ]  # fmt: skip
        for name, keywords, flags in cases:
            with self.subTest(name=name, flags=flags):
                ours, theirs = self.folder / "x" / "plan.json", self.folder / "y" / "plan.json"
                for path in (ours, theirs):
                    path.parent.mkdir(exist_ok=True)
                code, document, said = command("plan", "-m", "generic-ac", "-o", theirs, fixture(name), *flags)
                self.assertEqual(code, 0, said)
                done = trunnion.plan(fixture(name), "generic-ac", output=ours, **keywords)
                # Where the model was set up anew, the plan names it by its folder.
                here, there = (str(path.parent) for path in (ours, theirs))
                self.same(json.loads(done.to_json().replace(here, there)), document)
                self.assertEqual(ours.read_text().replace(here, there), theirs.read_text())
                self.assertEqual(ours.read_bytes(), done.plan)
                self.assertEqual([one.part for one in done.prints], [p["part"] for slot in document["slots"] for p in slot["prints"]])
                made = [path.with_suffix(".parts.3mf") for path in (ours, theirs)]
                self.assertEqual([path.exists() for path in made], [done.parts_3mf is not None] * 2)
                if made[0].exists():
                    self.assertEqual(made[0].read_bytes(), made[1].read_bytes())
                    made[0].unlink(), made[1].unlink()

    def test_each_keyword_is_its_flag(self):
        """A result or a failure, whatever the command makes of the same flag."""
        cube, hook, tree, caged = (fixture(name) for name in ("cube", "hook", "y-tree", "caged"))
        config = self.folder / "builtin.ini"
        config.write_text("layer_height = 0.3\nfill_density = 40%\n")
        gap = str(self.folder / "gap.3mf")
        trunnion.Model.from_meshes({"base": box((0, 0, 0), (20, 20, 10)), "arm": box((5, 5, 10.1), (15, 15, 22))}).write(gap)
        prepare = {"slicer": "builtin"}
        cases = [
            ("plan", tree, {"base": 0}, ["--base", "0"]),
            ("plan", tree, {"base": 1}, ["--base", "1"]),
            ("plan", gap, {}, []),
            ("plan", gap, {"snap_mm": 0}, ["--snap", "0"]),
            ("plan", tree, {"join": True}, ["--join"]),
            ("plan", tree, {"budget": 1}, ["--budget", "1"]),
            ("plan", tree, {"method": "grid", "orient_by": "staircase"}, ["--method", "grid", "--orient-by", "staircase"]),
            ("plan", tree, {"slots": "only-single"}, ["--slots", "only-single"]),
            ("plan", tree, {"unit": "cm"}, ["--unit", "cm"]),
            ("plan", tree, {"repair": False}, ["--no-repair"]),
            ("plan", cube, {"up": "auto"}, ["--up", "auto"]),
            ("plan", cube, {"up": (1, 2, 2)}, ["--up", "1,2,2"]),
            ("plan", hook, {"supports": "auto"}, ["--supports", "auto"]),
            ("plan", fixture("two-boxes"), {"origin_mm": (-15, 0)}, ["--origin=-15,0"]),
            ("plan", fixture("two-boxes"), {"turn_deg": 25}, ["--turn", "25"]),
            ("plan", fixture("two-boxes"), {"origin_mm": (-15, 0), "remedies": False}, ["--origin=-15,0", "--no-remedies"]),
            ("plan", caged, {"allow": {0: None}}, ["--allow", "0"]),
            ("prepare", hook, {**prepare, "split": "never", "supports": "never"}, ["--split", "never", "--supports", "never"]),
            ("prepare", hook, {**prepare, "split": "never"}, ["--split", "never"]),
            ("prepare", cube, {**prepare, "slicer_config": [config]}, ["--slicer-config", config]),
            ("prepare", cube, {**prepare, "bed": "120x110", "slicer_timeout_s": 20}, ["--bed", "120x110", "--slicer-timeout", "20"]),
            ("prepare", cube, {**prepare, "bed": "12x11"}, ["--bed", "12x11"]),
            ("split", hook, {"up": (1, 0, 0), "allow_mm2": 60}, ["--up", "1,0,0", "--allow", "60"]),
            ("split", hook, {"up": "auto", "overhang_deg": 60}, ["--up", "auto", "--overhang", "60"]),
            ("split", hook, {"finish": "fine"}, ["--finish", "fine"]),
            ("split", hook, {"bridge_mm": 3, "tolerate_mm2": 9, "allow_mm2": 70}, ["--bridge", "3", "--tolerate", "9", "--allow", "70"]),
        ]  # fmt: skip
        documents = set()
        for verb, model, keywords, flags in cases:
            with self.subTest(verb=verb, flags=flags):
                out = self.folder / "out.3mf"
                more = {"plan": [], "split": ["-o", out], "prepare": ["--slicer", "builtin", "-o", out]}[verb]
                machine = "open5x-prusa" if "two-boxes" in model else "generic-ac"
                code, document, said = command(verb, model, "-m", machine, *more, *flags)
                try:
                    if verb != "plan":
                        keywords = {**keywords, "output": out}
                    answer = (0, getattr(trunnion, verb)(model, machine, **keywords).to_dict())
                except trunnion.TrunnionError as error:
                    answer = (error.exit, error.to_dict())
                self.assertEqual(answer[0], code, said)
                if "error" in (document or {}):
                    # The command says how the setting is called there.
                    self.assertEqual(document["error"].removeprefix("--"), answer[1]["error"])
                else:
                    self.same(answer[1], document)
                documents.add(json.dumps(untimed(answer[1])))
        self.assertGreater(len(documents), len(cases) - 4)

    def test_no_plan(self):
        code, document, _ = command("plan", fixture("caged"), "-m", "generic-ac")
        with self.assertRaises(trunnion.NoPlanError) as caught:
            trunnion.plan(fixture("caged"), "generic-ac")
        error = caught.exception
        self.assertEqual((code, error.exit), (1, 1))
        self.same(error.to_dict(), document)
        self.assertTrue(error.reasons and str(error) == document["summary"])

    def test_split(self):
        model = trunnion.Model.from_arrays(*tee())
        model.write(self.folder / "tee.3mf")
        ours, theirs = self.folder / "ours.3mf", self.folder / "theirs.3mf"
        code, document, said = command("split", self.folder / "tee.3mf", "-m", "generic-ac", "-o", theirs)
        self.assertEqual(code, 0, said)
        done = trunnion.split(model, "generic-ac", output=ours)
        self.same(done.to_dict(), document)
        self.assertEqual(done.parts, document["parts"])
        self.assertEqual(ours.read_bytes(), theirs.read_bytes())
        self.assertEqual(done.parts_3mf, theirs.read_bytes())
        pins = [plane["pin"] for plane in document["planes"]]
        pinned = trunnion.split(model, "generic-ac", cuts=pins, max_cuts=len(pins))
        self.assertEqual(pinned.parts_3mf, done.parts_3mf)
        self.assertEqual(trunnion.split(model, "generic-ac", part=0).parts_3mf, done.parts_3mf)
        for wrong in (dict(cuts=["1,0,1"]), dict(cuts=["1,0,1,x"]), dict(cuts=[3]), dict(cuts="1,0,1,2"), dict(cuts=["1:1,0,1,2"]), dict(part=1)):
            with self.assertRaises(trunnion.InputError):
                trunnion.split(model, "generic-ac", **wrong)
        options = ["--max-cuts", "1", "--strict", "--no-cut", "-9,-9,-9,9,9,9", "--margin", "1", "--pedestal", "5"]
        code, document, _ = command("split", self.folder / "tee.3mf", "-m", "generic-ac", "-o", theirs, *options)
        keywords = dict(max_cuts=1, strict=True, no_cut=[[(-9, -9, -9), (9, 9, 9)]], margin_mm=1, pedestal_mm=5)
        try:
            answer = (0, trunnion.split(model, "generic-ac", **keywords).to_dict())
        except trunnion.NotPrintableError as error:
            answer = (error.exit, error.to_dict())
        self.assertEqual(answer[0], code)
        self.same(answer[1], document)

    def test_a_solid_that_stays_unprintable(self):
        code, document, said = command("split", fixture("hook"), "-m", "generic-ac", "-o", self.folder / "theirs.3mf", "--max-cuts", "1")
        with self.assertRaises(trunnion.NotPrintableError) as caught:
            trunnion.split(fixture("hook"), "generic-ac", output=self.folder / "ours.3mf", max_cuts=1)
        self.assertEqual((code, caught.exception.exit), (1, 1))
        self.same(caught.exception.to_dict(), document)
        self.assertIn(str(caught.exception), said)
        self.assertFalse((self.folder / "ours.3mf").exists())

    def test_support(self):
        cases = [
            ({}, []),
            ({"step_mm": 3, "method": "min-cost", "structure": "prism", "gap_mm": 0.4, "overhang_deg": 30, "seed": 5},
             ["--step", "3", "--method", "min-cost", "--structure", "prism", "--gap", "0.4", "--overhang", "30", "--seed", "5"]),
            ({"up": (1, 0, 0), "capacity": 2, "node_capacity": 3, "wall_mm": 0.6, "roof_mm": 1, "roof_pitch_mm": 1.4, "brace_mm": 9},
             ["--up", "1,0,0", "--capacity", "2", "--node-capacity", "3", "--wall", "0.6", "--roof", "1", "--roof-pitch", "1.4", "--brace", "9"]),
            ({"space_mm": (90, 90, 90), "keep_z": True}, ["--space", "90,90,90", "--keep-z"]),
        ]  # fmt: skip
        documents = set()
        for keywords, flags in cases:
            with self.subTest(flags=flags):
                for ending in ("stl", "3mf"):
                    ours, theirs = self.folder / f"ours.{ending}", self.folder / f"theirs.{ending}"
                    code, document, said = command("support", fixture("hook"), "-o", theirs, *flags)
                    try:
                        done = trunnion.support(fixture("hook"), output=ours, **keywords)
                    except trunnion.InputError as error:
                        self.assertEqual((code, document["code"], document["exit"]), (2, error.code, error.exit), said)
                        documents.add(error.text)
                        continue
                    self.assertEqual(code, 0, said)
                    self.same(done.to_dict(), document)
                    self.assertEqual(ours.read_bytes(), theirs.read_bytes())
                    self.assertEqual({"stl": done.supports_stl, "3mf": done.model_3mf}[ending], theirs.read_bytes())
                    done.write(self.folder / f"written.{ending}")
                    self.assertEqual((self.folder / f"written.{ending}").read_bytes(), theirs.read_bytes())
                    self.assertGreaterEqual(done.cost, done.lower_bound)
                    documents.add(json.dumps(untimed(document)))
        self.assertEqual(len(documents), len(cases))

    def test_support_of_what_stands_by_itself_and_of_what_cannot_have_any(self):
        done = trunnion.support(fixture("cube"), output=self.folder / "cube.stl")
        self.assertEqual((done.red, done.supports_stl, done.model_3mf, list(self.folder.iterdir())), (0, None, None, []))
        # The ceiling of a closed room: below it is the room's own floor.
        walls = {
            "floor": box((0, 0, 0), (40, 40, 4)), "roof": box((0, 0, 20), (40, 40, 24)), "left": box((0, 0, 4), (4, 40, 20)),
            "right": box((36, 0, 4), (40, 40, 20)), "front": box((4, 0, 4), (36, 4, 20)), "back": box((4, 36, 4), (36, 40, 20)),
        }  # fmt: skip
        model = trunnion.Model.from_meshes(walls)
        model.write(self.folder / "room.3mf")
        code, document, _ = command("support", self.folder / "room.3mf", "-o", self.folder / "theirs.stl")
        with self.assertRaises(trunnion.NoSupportError) as caught:
            trunnion.support(model, output=self.folder / "ours.stl")
        self.assertEqual((code, caught.exception.exit), (1, 1))
        self.same(caught.exception.to_dict(), document)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["room.3mf"])
        with self.assertRaises(trunnion.InputError) as caught:
            trunnion.support(fixture("hook"), output=self.folder / "supports.obj")
        self.assertEqual(caught.exception.code, "setting/ending")

    def test_pack(self):
        cube, tree, hook = (fixture(name) for name in ("cube", "y-tree", "hook"))
        boxes = self.folder / "boxes.txt"
        boxes.write_text("20 30 15.5 4 1.5\n40 40 40 2 9 up\n10 10 70\n")
        rows = [(20, 30, 15.5, 4, 1.5), [40, 40, 40, 2, 9, "up"], np.array([10.0, 10.0, 70.0])]
        cases = [
            ([(cube, 3), tree], {"space_mm": (90, 90, 80)}, [cube + "*3", tree, "--space", "90,90,80"]),
            ([(cube, np.int64(5)), (hook, 2)], {"profile": "generic-ac", "gap_mm": 30, "turn": "z90"},
             [cube + "*5", hook + "*2", "-m", "generic-ac", "--gap", "30", "--turn", "z90"]),
            (cube, {"space_mm": [60, 60], "goal": "height", "time_s": 20}, [cube, "--space", "60,60", "--goal", "height", "--time", "20"]),
            ([(cube, 6)], {"space_mm": (45, 45, 25), "fill": [2.5], "seed": 4, "turn": "any", "no_interlock": True, "inflate_mm": 1},
             [cube + "*6", "--space", "45,45,25", "--fill", "2.5", "--seed", "4", "--turn", "any", "--no-interlock", "--inflate", "1"]),
            (None, {"boxes": boxes, "space_mm": (60, 60, 80), "turn": "any"}, ["--boxes", boxes, "--space", "60,60,80", "--turn", "any"]),
            (None, {"boxes": boxes.read_bytes(), "space_mm": (60, 60, 60), "fill": "file", "turn": "any"},
             ["--boxes", boxes, "--space", "60,60,60", "--fill", "file", "--turn", "any"]),
            (None, {"boxes": rows, "space_mm": (60, 60, 80), "method": "ip-local-search", "used_distance": 2, "direction_distance": 9},
             ["--boxes", boxes, "--space", "60,60,80", "--method", "ip-local-search", "--used-distance", "2", "--direction-distance", "9"]),
        ]  # fmt: skip
        for number, (models, keywords, flags) in enumerate(cases):
            with self.subTest(flags=flags):
                ours, theirs = self.folder / f"ours-{number}", self.folder / f"theirs-{number}"
                code, document, said = command("pack", "-o", theirs, *flags)
                self.assertEqual(code, 0, said)
                done = trunnion.pack(models, output=ours, **keywords)
                # What is in hand has no file's name.
                named = json.loads(done.to_json().replace("boxes, line", f"{boxes}, line")) if "boxes" in keywords else done.to_dict()
                self.same(named, document)
                files = sorted(path.name for path in theirs.iterdir())
                self.assertEqual(files, sorted(path.name for path in ours.iterdir()))
                self.assertEqual(files, [plate.file for plate in done.plates])
                self.assertEqual([(ours / name).read_bytes() for name in files], [(theirs / name).read_bytes() for name in files])
                self.assertEqual(done.plates_3mf, [(theirs / name).read_bytes() for name in files])
                self.assertEqual([len(plate.items) for plate in done.plates], [len(plate["items"]) for plate in document["plates"]])
        done.write(self.folder / "written")
        self.assertEqual([path.read_bytes() for path in sorted((self.folder / "written").iterdir())], done.plates_3mf)

    def test_packing_again_and_what_cannot_be_packed(self):
        out = self.folder / "plates"
        self.assertGreater(trunnion.pack([(fixture("cube"), 4)], space_mm=(25, 25, 25), output=out).runs, 1)
        with self.assertWarns(trunnion.TrunnionWarning):
            trunnion.pack(fixture("cube"), space_mm=(25, 25, 25), output=out, view=self.folder / "plates.svg")
        self.assertEqual(sorted(path.name for path in out.iterdir() if path.suffix == ".3mf"), ["plate-01.3mf"])
        self.assertTrue((out / "plate-02.3mf.stale").exists() and (self.folder / "plates.svg").exists())
        cube = fixture("cube")
        for words, keywords, flags in [
            ([cube], {"space_mm": (5, 5, 5)}, [cube, "--space", "5,5,5"]),
            ([(cube, 0)], {"space_mm": (50, 50, 50)}, [cube + "*0", "--space", "50,50,50"]),
            ([cube], {"space_mm": (50, 50)}, [cube, "--space", "50,50"]),
            ([cube], {"space_mm": (50, 50, 50), "turn": "sideways"}, [cube, "--space", "50,50,50", "--turn", "sideways"]),
            ([cube], {"space_mm": (50, 50, 50), "gap_mm": -1}, [cube, "--space", "50,50,50", "--gap", "-1"]),
            ([cube], {"profile": "generic-ac", "goal": "height"}, [cube, "-m", "generic-ac", "--goal", "height"]),
        ]:
            code, document, said = command("pack", *flags)
            with self.subTest(flags=flags), self.assertRaises(trunnion.InputError) as caught:
                trunnion.pack(words, **keywords)
            self.assertEqual((caught.exception.exit, caught.exception.code), (code, document["code"]), said)
        for words, keywords in [
            (None, {"space_mm": (9, 9, 9)}), ([cube], {}), ([cube], {"boxes": [(1, 1, 1)], "space_mm": (9, 9, 9)}),
            ([cube], {"space_mm": (9, 9, 9), "profile": "generic-ac"}), ([cube], {"space_mm": (9, 9, 9), "used_distance": 2}),
            ([(cube, -1)], {"space_mm": (9, 9, 9)}), ([(cube, 10**30)], {"space_mm": (9, 9, 9)}), (3, {"space_mm": (9, 9, 9)}),
            (None, {"boxes": [(1, 1)], "space_mm": (9, 9, 9)}), (None, {"boxes": [("a\ud800", 1, 1)], "space_mm": (9, 9, 9)}),
            (None, {"boxes": [3], "space_mm": (9, 9, 9)}), ([cube], {"space_mm": (9, float("nan"), 9)}),
        ]:  # fmt: skip
            with self.subTest(words=words, keywords=keywords), self.assertRaises(trunnion.InputError) as caught:
                trunnion.pack(words, **keywords)
            self.assertTrue(caught.exception.code)

    def test_prepare_and_verify(self):
        for name, keywords, flags in [
            ("two-boxes", {"overhang_deg": 40}, ["--overhang", "40"]),
            ("cube", {"copies": 2, "up": (1, 0, 0)}, ["--up", "1,0,0"]),
        ]:
            with self.subTest(name=name):
                out, plan = self.folder / "out.gcode", self.folder / "out.json"
                given = fixture(name) + ("*2" if "copies" in keywords else "")
                words = [given, "-m", "generic-ac", "--slicer", "builtin", *flags, "-o", out, "--plan-out", plan]
                code, document, said = command("prepare", *words)
                self.assertEqual(code, 0, said)
                theirs = [path.read_bytes() for path in (out, plan)]
                done = trunnion.prepare(fixture(name), "generic-ac", slicer="builtin", output=out, plan_out=plan, **keywords)
                self.same(done.to_dict(), document)
                self.assertEqual([path.read_bytes() for path in (out, plan)], theirs)
                self.assertEqual([done.gcode, done.plan_file], theirs)
                self.assertTrue(done.verify.clean and done.verify.moves == document["verify"]["moves"])
                code, document, _ = command("verify", out, "--plan", plan)
                self.assertEqual(code, 0)
                self.same(trunnion.verify(out, plan).to_dict(), document)
                # What the heads of their files say is beside the first line: half of the print is missing.
                out.write_bytes(b"".join(theirs[0].splitlines(True)[:-2000]))
                code, document, _ = command("verify", out, "--plan", plan)
                report = trunnion.verify(out.read_bytes(), plan.read_bytes())
                self.assertEqual((code, report.clean), (1, False))
                self.same(report.to_dict(), document)
                self.assertEqual([one.rule for one in report.findings], [one["rule"] for one in document["findings"]])

    def test_prepare_in_memory(self):
        model = trunnion.Model.from_meshes({"base": box((0, 0, 0), (20, 20, 10)), "arm": box((5, 5, 10), (15, 15, 22))})
        done = trunnion.prepare(model, "generic-ac", slicer="builtin")
        self.assertIsNone(done.output)
        self.assertEqual(len(done.plan.parts), 2)
        self.assertTrue(trunnion.verify(done, model=model).clean)
        model.write(self.folder / "model.3mf")
        done.write(self.folder / "out.gcode")
        code, _, said = command("prepare", "model.3mf", "-m", "generic-ac", "--slicer", "builtin", "-o", "theirs.gcode", cwd=self.folder)
        self.assertEqual(code, 0, said)
        self.assertEqual((self.folder / "theirs.gcode").read_bytes(), done.gcode)

    def test_a_solid_that_is_cut(self):
        model = trunnion.Model("tee.3mf", trunnion.Model.from_arrays(*tee()).data)
        model.write(self.folder / "tee.3mf")
        code, document, said = command("prepare", "tee.3mf", "-m", "generic-ac", "--slicer", "builtin", "-o", "theirs.gcode", cwd=self.folder)
        self.assertEqual(code, 0, said)
        done = trunnion.prepare(model, "generic-ac", slicer="builtin")
        self.assertEqual(len(done.plan.parts), len(document["plan"]["parts"]))
        self.assertEqual(done.parts_3mf, (self.folder / "theirs.parts.3mf").read_bytes())
        self.assertTrue(trunnion.verify(done).clean)

    def test_profiles(self):
        for name in trunnion.Profile.shipped():
            profile = trunnion.Profile(name)
            _, document, _ = command("profile", "show", name)
            self.assertEqual(profile.to_dict(), document)
            carried = trunnion.Profile.from_toml(profile.to_toml(), name)
            self.assertEqual((carried.sha256, carried.to_dict()), (profile.sha256, profile.to_dict()))


class Failures(Folder):
    """What the command refuses is refused with its sentence and its exit code."""

    def refused(self, *words):
        run = subprocess.run([COMMAND, *map(str, words), "--json"], capture_output=True, text=True)
        document = json.loads(run.stdout)
        self.assertEqual((document["exit"], f"error[{document['code']}]: {document['error']}"), (run.returncode, run.stderr.strip().splitlines()[-1]))
        return document

    def test_a_model_that_is_not_there(self):
        document = self.refused("inspect", self.folder / "none.stl")
        with self.assertRaises(trunnion.InputError) as caught:
            trunnion.inspect(self.folder / "none.stl")
        self.assertEqual(caught.exception.to_dict(), document)
        self.assertIsInstance(caught.exception, ValueError)

    def test_an_open_model(self):
        vertices, facets = box((0, 0, 0), (1, 1, 1))
        model = trunnion.Model.from_arrays(vertices, facets[:-1])
        model.write(self.folder / "open.3mf")
        for flags, repair in [(["--no-repair"], False), (["--repair", "off"], "off"), (["--repair", "strict"], "strict")]:
            document = self.refused("inspect", self.folder / "open.3mf", *flags)
            with self.subTest(repair=repair), self.assertRaises(trunnion.InputError) as caught:
                trunnion.inspect(self.folder / "open.3mf", repair=repair)
            self.assertEqual(caught.exception.to_dict(), document)

    def test_settings(self):
        for keyword, value, said in [
            ("overhang_deg", 100, "overhang must be between 0 and 90 deg, got 100 deg"),
            ("overhang_deg", float("nan"), "overhang_deg nan is not a finite number"),
            ("overhang_deg", "steep", "overhang_deg 'steep' is not a finite number"),
            ("margin_mm", True, "margin_mm True is not a finite number"),
            ("seed", -1, "seed -1 is not a whole number of at least 0"),
            ("slots", "two", "slots 'two' is not one of together, single, only-single"),
            ("origin_mm", (1, 2, 3), "origin_mm (1, 2, 3) is not 2 finite numbers"),
            ("up", "sideways", "up 'sideways' is not 3 finite numbers"),
            ("up", (0, 0, 0), "up 0,0,0 has no direction"),
            ("objective", "bsss", "objective: "),
            ("objective", 3, "objective 3 is not a string"),
            ("allow", {9: 1}, "has no part 9"),
            ("allow", {"x": 1}, "beside and allow"),
            ("beside", 3, "beside and allow"),
            ("top", 0, "top must be between 1 and 100, got 0"),
            ("output", self.folder / "none" / "plan.json", "does not exist"),
            ("output", 3, "int is not a path"),
            ("sheet", self.folder / "plan.doc", "sheet "),
            ("unit", "inch", "inch"),
            ("repair", "yes", "repair 'yes' is not True, False, 'auto', 'strict' or 'off'"),
            ("threads", 1025, "threads 1025 is not a whole number from 0 to 1024"),
            ("threads", 10**30, "is not a whole number from 0 to 1024"),
            ("threads", -1, "threads -1 is not a whole number from 0 to 1024"),
            ("threads", True, "threads True is not a whole number from 0 to 1024"),
        ]:
            with self.subTest(keyword=keyword, value=value), self.assertRaises(trunnion.InputError) as caught:
                trunnion.plan(fixture("cube"), "generic-ac", **{keyword: value})
            self.assertIn(said, str(caught.exception))
            self.assertEqual(caught.exception.exit, 2)
        with self.assertRaises(TypeError):
            trunnion.plan(fixture("cube"), "generic-ac", overhangs=3)

    def test_machines(self):
        for machine, said in [("generic-a", 'nearest: "generic-ac"'), (str(self.folder / "m.toml"), "file not found"), (3, "int is not a machine")]:
            with self.subTest(machine=machine), self.assertRaises(trunnion.InputError) as caught:
                trunnion.plan(fixture("cube"), machine)
            self.assertIn(said, str(caught.exception))
        with self.assertRaisesRegex(trunnion.InputError, "marginn"):
            trunnion.Profile.from_toml("[machine]\nmarginn = 3\n")

    def test_a_slicer_that_is_not_there(self):
        with self.assertRaises(trunnion.TrunnionError) as caught:
            trunnion.prepare(fixture("cube"), "generic-ac", slicer=str(self.folder / "slicer"))
        self.assertTrue(str(caught.exception))

    def test_an_output_that_is_an_input(self):
        kept = self.folder / "cube.stl"
        kept.write_bytes(Path(fixture("cube")).read_bytes())
        with self.assertRaisesRegex(trunnion.InputError, "is also an input"):
            trunnion.plan(kept, "generic-ac", output=kept)
        self.assertEqual(kept.read_bytes(), Path(fixture("cube")).read_bytes())

    def test_an_earlier_file_is_put_aside(self):
        out = self.folder / "out.gcode"
        out.write_text("G28\n")
        with self.assertRaises(trunnion.NoPlanError):
            trunnion.prepare(fixture("caged"), "generic-ac", slicer="builtin", output=out, split="never", supports="never")
        self.assertFalse(out.exists())
        self.assertEqual((self.folder / "out.gcode.stale").read_text(), "G28\n")


class Names(Folder):
    """Paths that are no UTF-8 are paths; what no file can be called is refused, by this package and with a code."""

    def setUp(self):
        super().setUp()
        self.odd = self.folder / os.fsdecode(b"ordner-\xe9")
        try:
            self.odd.mkdir()
        except OSError:
            self.skipTest("this system has no such names")

    def test_models_and_outputs(self):
        model = self.odd / os.fsdecode(b"w\xfcrfel-\xff.stl")
        model.write_bytes(Path(fixture("cube")).read_bytes())
        self.assertEqual(trunnion.inspect(model).to_dict(), trunnion.inspect(fixture("cube")).to_dict())
        self.assertEqual(trunnion.inspect(os.fsencode(model).decode(errors="surrogateescape")).parts, trunnion.inspect(model).parts)
        trunnion.orient(model, objective="height", output=self.odd / os.fsdecode(b"\xfe.stl"), landscape=self.odd / os.fsdecode(b"\xfe.svg"))
        trunnion.pack([(model, 2)], space_mm=(90, 90, 90), output=self.odd / os.fsdecode(b"plates-\xfe"))
        hook = self.odd / os.fsdecode(b"hook-\xff.stl")
        hook.write_bytes(Path(fixture("hook")).read_bytes())
        trunnion.support(hook, output=self.odd / os.fsdecode(b"s-\xfe.stl"), view=self.odd / os.fsdecode(b"s-\xfe.png"))
        own = self.odd / os.fsdecode(b"m-\xfe.toml")
        own.write_text(trunnion.Profile("generic-ac").to_toml())
        self.assertEqual(trunnion.Profile(own).sha256, trunnion.Profile("generic-ac").sha256)
        done = trunnion.prepare(fixture("cube"), own, slicer="builtin", output=self.odd / os.fsdecode(b"out-\xfe.gcode"))
        self.assertEqual(Path(done.output).read_bytes(), done.gcode)
        page = self.odd / os.fsdecode(b"page-\xfe.html")
        self.assertEqual(trunnion.preview(done, model=fixture("cube"), profile="generic-ac", output=page).page, page.read_bytes())
        made = {os.fsencode(path.name) for path in self.odd.iterdir()}
        wanted = [b"\xfe.stl", b"\xfe.svg", b"plates-\xfe", b"s-\xfe.stl", b"s-\xfe.png", b"out-\xfe.gcode", b"page-\xfe.html"]
        self.assertLessEqual(set(wanted), made)

    def test_a_plan_names_its_model_by_text(self):
        """What a plan cannot name is refused, or found again: never an error of the codec."""
        model = self.odd / os.fsdecode(b"w\xfcrfel-\xff.stl")
        model.write_bytes(Path(fixture("cube")).read_bytes())
        for verb in (trunnion.plan, trunnion.prepare):
            more = {"slicer": "builtin"} if verb is trunnion.prepare else {}
            with self.subTest(verb=verb.__name__):
                done = verb(model, "generic-ac", **more)
                self.assertIn("generic-ac", json.dumps(done.to_dict()))
        code, document, _ = command("verify", self.folder / "x.gcode", "--plan", self.odd / os.fsdecode(b"p-\xff.json"))
        with self.assertRaises(trunnion.InputError) as caught:
            trunnion.verify(self.folder / "x.gcode", self.odd / os.fsdecode(b"p-\xff.json"))
        self.assertEqual((caught.exception.exit, caught.exception.code), (code, document["code"]))

    def test_what_no_file_can_be_called(self):
        cube, bad = fixture("cube"), "a\ud800b"
        for number, call in enumerate([
            lambda: trunnion.inspect(bad), lambda: trunnion.inspect(trunnion.Model(bad, Path(cube).read_bytes())),
            lambda: trunnion.plan(cube, bad), lambda: trunnion.Profile(bad + ".toml"), lambda: trunnion.Profile.from_toml(bad),
            lambda: trunnion.Profile.from_toml("", bad), lambda: trunnion.plan(cube, "generic-ac", output=bad),
            lambda: trunnion.plan(cube, "generic-ac", sheet=bad), lambda: trunnion.orient(cube, objective=bad),
            lambda: trunnion.prepare(cube, "generic-ac", slicer=bad), lambda: trunnion.prepare(cube, "generic-ac", slicer_config=[bad]),
            lambda: trunnion.Model.from_arrays(*box((0, 0, 0), (1, 1, 1)), name=bad), lambda: trunnion.inspect(cube, unit=bad),
            lambda: trunnion.verify(bad, "plan.json"), lambda: trunnion.pack([bad], space_mm=(9, 9, 9)), lambda: trunnion.inspect("a\0b"),
            lambda: trunnion.preview(cube, profile="generic-ac", output=bad), lambda: trunnion.support(fixture("hook"), output="a\0b.stl"),
            lambda: trunnion.publish(b"G28", to=bad, unverified=True), lambda: trunnion.publish(b"G28", to="octoprint:http://x", key=bad, unverified=True),
            lambda: trunnion.send(b"G28", port=bad, unverified=True, journal="j", profile="generic-ac"),
        ]):  # fmt: skip
            with self.subTest(call=number), self.assertRaises(trunnion.InputError) as caught:
                call()
            self.assertTrue(caught.exception.code)


class Arrays(Folder):
    def test_arrays_bytes_and_files_are_one_model(self):
        vertices, facets = tee()
        vertices = vertices * np.pi / 3 + 1e-3
        model = trunnion.Model.from_arrays(vertices, facets)
        model.write(self.folder / "model.3mf")
        _, document, _ = command("inspect", self.folder / "model.3mf")
        for given in [self.folder / "model.3mf", str(self.folder / "model.3mf"), model, model.data, bytearray(model.data), (vertices, facets)]:
            self.assertEqual(trunnion.inspect(given).to_dict(), document)
        # float64 to the bit: the box's corners are coordinates of the array.
        box = trunnion.inspect(model).parts[0].box_mm
        self.assertEqual(box, [vertices.min(axis=0).tolist(), vertices.max(axis=0).tolist()])

    def test_the_volume_of_an_array(self):
        done = trunnion.inspect(box((1, 2, 3), (4, 7, 10)))
        self.assertAlmostEqual(done.parts[0].volume_mm3, 3 * 5 * 7, places=9)

    def test_layout_and_dtype_do_not_matter(self):
        vertices, facets = box((0, 0, 0), (2, 3, 4))
        expected = trunnion.Model.from_arrays(vertices, facets)
        wide, reversed_twice = np.zeros((8, 6)), np.ascontiguousarray(facets[::-1])[::-1]
        wide[:, ::2] = vertices
        for one, other in [
            (np.asfortranarray(vertices), np.asfortranarray(facets)),
            (wide[:, ::2], reversed_twice),
            (vertices.astype(np.float32), facets.astype(np.int32)),
            (vertices.astype(">f8"), facets.astype(np.uint8)),
            (vertices.astype(int), facets.astype(np.uint64)),
            (vertices.tolist(), facets.tolist()),
        ]:
            self.assertEqual(trunnion.Model.from_arrays(one, other), expected)
        read_only = vertices.copy()
        read_only.flags.writeable = False
        self.assertEqual(trunnion.Model.from_arrays(read_only, facets), expected)
        self.assertFalse((wide[:, ::2]).flags.c_contiguous)

    def test_arrays_that_are_none(self):
        vertices, facets = box((0, 0, 0), (1, 1, 1))
        bad = vertices.copy()
        bad[5, 1] = np.nan
        endless = vertices.copy()
        endless[0, 0] = np.inf
        high, low = facets.copy(), facets.copy()
        high[7, 2], low[3, 0] = 8, -1
        huge = facets.astype(np.uint64)
        huge[0, 0] = 2**63
        for given, said in [
            ((bad, facets), "part: vertex 5 is (1, NaN, 1); coordinates must be finite numbers"),
            ((endless, facets), "vertex 0 is (inf, 0, 0)"),
            ((vertices, high), "part: facet 7 refers to vertex 8; the vertices are 0..7"),
            ((vertices, low), "part: facet 3 refers to vertex -1; the vertices are 0..7"),
            ((vertices, huge), "facets name vertex 9223372036854775808"),
            ((vertices[:, :2], facets), "part: vertices must have 3 columns (n x 3), got shape 8 x 2"),
            ((vertices, facets[:, :2]), "facets must have 3 columns (n x 3), got shape 12 x 2"),
            ((vertices.ravel(), facets), "vertices have 1 dimensions"),
            ((vertices[None], facets), "vertices have 3 dimensions"),
            ((vertices[:0], facets), "part: vertices are empty"),
            ((vertices, facets[:0]), "part: facets are empty"),
            ((vertices.astype(str), facets), "vertices of dtype <U"),
            ((vertices.astype(complex), facets), "vertices of dtype complex128"),
            ((vertices.astype(object), facets), "vertices of dtype object"),
            ((vertices > 0, facets), "vertices of dtype bool"),
            ((vertices, facets.astype(float)), "facets of dtype float64; whole numbers are wanted"),
            (([[0, 0, 0], [1]], facets), "vertices are no array"),
            ((vertices, facets, facets), "a tuple of 3 is no model"),
        ]:
            with self.subTest(said=said), self.assertRaises(trunnion.InputError) as caught:
                trunnion.inspect(given)
            self.assertIn(said, str(caught.exception))
        for given, said in [({}, "no meshes"), ({"a": vertices}, "a: ndarray is no pair")]:
            with self.assertRaisesRegex(trunnion.InputError, said):
                trunnion.Model.from_meshes(given)
        with self.assertRaisesRegex(trunnion.InputError, "NoneType is not a model"):
            trunnion.inspect(None)

    def test_many_facets(self):
        count = 300
        x, y = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
        top = np.stack([x, y, 5 + np.sin(x / 9.0) * np.cos(y / 7.0)], axis=-1).reshape(-1, 3)
        bottom = top * [1, 1, 0]
        at = np.arange(count * count).reshape(count, count)
        a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
        sheet = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
        rim = np.concatenate([at[:, 0], at[-1, 1:], at[-2::-1, -1], at[0, -2::-1]])[:-1]
        after, under = np.roll(rim, -1), count * count
        walls = np.concatenate([np.stack([rim, rim + under, after], 1), np.stack([after, rim + under, after + under], 1)])
        facets = np.concatenate([sheet, sheet[:, ::-1] + under, walls])
        self.assertGreater(len(facets), 350_000)
        done = trunnion.inspect((np.concatenate([top, bottom]), facets))
        volume = np.sum((top[sheet][:, :, 2].sum(axis=1)) / 6)
        self.assertAlmostEqual(done.parts[0].volume_mm3 / volume, 1, places=9)


class Stopped(Exception):
    pass


class Watched(Folder):
    def test_progress_and_warnings(self):
        seen = []
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            done = trunnion.prepare(fixture("hook"), "generic-ac", slicer="builtin", progress=seen.append)
        self.assertEqual([one.text for one in seen if one.kind == "reached"], ["read", "planned", "sliced"])
        slicing = [one for one in seen if one.kind == "step" and one.text == "slicing"]
        self.assertEqual((slicing[0].done, slicing[-1].done), (0, slicing[-1].of))
        self.assertEqual([str(one.message) for one in warned], [one.text for one in seen if one.kind == "warning"])
        self.assertTrue(done.verify.clean)

    def test_the_logger_hears_the_same(self):
        seen = []
        with warnings.catch_warnings(), self.assertLogs("trunnion", level="DEBUG") as heard:
            warnings.simplefilter("ignore")
            trunnion.prepare(fixture("hook"), "generic-ac", slicer="builtin", progress=seen.append)
        text = {"step": lambda one: f"{one.text}: {one.done} of {one.of}"}
        self.assertEqual(
            [record.getMessage() for record in heard.records], [text.get(one.kind, lambda one: one.text)(one) for one in seen]
        )
        levels = {"warning": logging.WARNING, "reached": logging.INFO, "step": logging.DEBUG}
        self.assertEqual([record.levelno for record in heard.records], [levels[one.kind] for one in seen])

    def test_a_warning_names_the_callers_line(self):
        model = trunnion.Model.from_meshes({"one": box((0, 0, 0), (20, 20, 10)), "other": box((0, 0, 5), (20, 20, 15))})
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            trunnion.inspect(model)
        self.assertTrue(warned and warned[0].category is trunnion.TrunnionWarning)
        self.assertEqual(warned[0].filename, __file__)

    def test_a_callback_that_raises_ends_the_job(self):
        out = self.folder / "out.gcode"

        def stop(progress):
            raise Stopped(progress.text)

        for verb in (trunnion.prepare, trunnion.orient, trunnion.split):
            begun = threading.active_count()
            with self.subTest(verb=verb.__name__), self.assertRaises(Stopped):
                if verb is trunnion.orient:
                    verb(fixture("hook"), progress=stop, output=out)
                else:
                    verb(fixture("hook"), "generic-ac", progress=stop, output=out)
            self.assertEqual((list(self.folder.iterdir()), threading.active_count()), ([], begun))

    def test_the_last_word_can_still_stop_it(self):
        """The job waits for the callback: what raises at the last step has no file written behind it."""
        seen = []
        trunnion.prepare(fixture("cube"), "generic-ac", slicer="builtin", progress=seen.append)

        def stop(progress):
            stop.left -= 1
            if not stop.left:
                # A job that did not wait would be done meanwhile.
                time.sleep(2)
                raise Stopped

        stop.left = len(seen)
        with self.assertRaises(Stopped):
            trunnion.prepare(fixture("cube"), "generic-ac", slicer="builtin", progress=stop, output=self.folder / "out.gcode")
        self.assertEqual((stop.left, list(self.folder.iterdir())), (0, []))

    def test_a_callback_that_is_none(self):
        with self.assertRaisesRegex(trunnion.InputError, "progress 3 cannot be called"):
            trunnion.inspect(fixture("cube"), progress=3)

    def test_a_callback_may_ask_itself(self):
        inner = []
        trunnion.orient(fixture("cube"), objective="height", progress=lambda p: inner.append(trunnion.inspect(fixture("cube"))))
        self.assertTrue(inner and inner[0].parts[0].facets == 12)

    def test_ctrl_c(self):
        out = self.folder / "out.gcode"
        timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
        began = time.monotonic()
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            trunnion.prepare(fixture("candelabrum"), "generic-ac", slicer="builtin", output=out, plan_out=self.folder / "out.json")
        took = time.monotonic() - began
        timer.join()
        self.assertEqual(list(self.folder.iterdir()), [], f"after {took:.2f} s")
        # Whatever was left to end by itself writes nothing later.
        time.sleep(1.0)
        self.assertEqual(list(self.folder.iterdir()), [])
        self.assertTrue(trunnion.inspect(fixture("cube")).parts)

    def test_the_interpreter_is_free(self):
        counted, stop = [0], threading.Event()

        def count():
            while not stop.is_set():
                counted[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        before = counted[0]
        trunnion.plan(fixture("candelabrum"), "generic-ac", threads=1)
        after = counted[0]
        stop.set()
        thread.join()
        self.assertGreater(after - before, 5)


def facets_of(model):
    return trunnion.inspect(model).parts[0].facets


def raised_in(model):
    try:
        trunnion.plan(model, "generic-ac")
    except trunnion.NoPlanError as error:
        return error


class Elsewhere(Folder):
    def test_pickles(self):
        model = trunnion.Model.from_arrays(*box((0, 0, 0), (20, 20, 10)))
        prepared = trunnion.prepare(model, "generic-ac", slicer="builtin")
        values = [
            model, prepared, trunnion.inspect(model), trunnion.orient(model, objective="height"), trunnion.plan(model, "generic-ac"),
            trunnion.verify(prepared, model=model), trunnion.split(trunnion.Model.from_arrays(*tee()), "generic-ac"),
            trunnion.Profile("fibr3d"), trunnion.Progress("step", "slicing", 1, 2),
        ]  # fmt: skip
        for value in values:
            again = pickle.loads(pickle.dumps(value))
            self.assertEqual(again, value)
            if hasattr(value, "to_dict"):
                self.assertEqual(again.to_dict(), value.to_dict())
        self.assertEqual(pickle.loads(pickle.dumps(prepared)).gcode, prepared.gcode)
        error = raised_in(fixture("caged"))
        again = pickle.loads(pickle.dumps(error))
        self.assertEqual((type(again), str(again), again.to_dict(), again.exit), (type(error), str(error), error.to_dict(), 1))

    def test_a_profile_goes_without_its_file(self):
        own = self.folder / "own.toml"
        own.write_text('extends = "generic-ac"\n[machine]\nname = "own"\nabout = "mine"\n[process]\nlayer_height_mm = 0.3\n')
        profile = trunnion.Profile(own)
        here = trunnion.plan(fixture("two-boxes"), profile)
        sent = pickle.dumps(profile)
        own.unlink()
        again = pickle.loads(sent)
        self.assertEqual(again.to_dict()["process"]["layer_height_mm"], 0.3)
        self.same(trunnion.plan(fixture("two-boxes"), again).to_dict(), here.to_dict())

    def test_processes_by_fork_and_by_spawn(self):
        expected = facets_of(fixture("y-tree"))
        trunnion.plan(fixture("two-boxes"), "generic-ac")
        for kind in ("fork", "spawn"):
            with multiprocessing.get_context(kind).Pool(2) as pool:
                self.assertEqual(pool.map_async(facets_of, [fixture("y-tree")] * 3).get(60), [expected] * 3)
                self.assertTrue(pool.apply_async(raised_in, [fixture("caged")]).get(60).reasons)

    def test_threads_change_nothing(self):
        one, two = (trunnion.prepare(fixture("y-tree"), "generic-ac", slicer="builtin", threads=count) for count in (1, 2))
        self.assertEqual((one.gcode, one.plan_file), (two.gcode, two.plan_file))

    def test_calls_of_several_threads(self):
        found = {}

        def one(name):
            found[name] = trunnion.plan(fixture(name), "generic-ac").plan

        names = ["two-boxes", "y-tree", "cube", "candelabrum"]
        threads = [threading.Thread(target=one, args=[name]) for name in names]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, {name: trunnion.plan(fixture(name), "generic-ac").plan for name in names})


class Described(unittest.TestCase):
    def test_everything_public_says_what_it_is(self):
        for name in trunnion.__all__:
            if name not in ("ModelLike", "ProfileLike", "__version__"):
                self.assertTrue((getattr(trunnion, name).__doc__ or "").strip(), name)
        self.assertTrue((Path(trunnion.__file__).parent / "py.typed").exists())
        self.assertTrue((Path(trunnion.__file__).parent / "_trunnion.pyi").exists())

    def test_the_version_is_the_commands(self):
        said = subprocess.run([COMMAND, "--version"], capture_output=True, text=True).stdout.split()[-1]
        self.assertEqual(trunnion.__version__, said)


if __name__ == "__main__":
    unittest.main()
