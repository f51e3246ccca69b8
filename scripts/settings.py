#!/usr/bin/env python3
"""Runs `trunnion prepare` over settings that users have in their slicers and prints a table: verified, refused and why, or rejected by `verify`.

    settings.py TRUNNION --slicer NAME MODEL .. [--machine PROFILE] [--only WORDS] [--out TABLE.tsv]

A setting is given to the slicer as its user's own configuration (`--slicer-config`). The slicers are the ones found in PATH. PrusaSlicer, Slic3r
and the built-in slicer share their words, as far as they have them; CuraEngine has its own.
"""

import argparse
import collections
import json
import os
import subprocess
import sys
import tempfile

PATTERNS = {
    "prusa": "rectilinear alignedrectilinear grid triangles stars cubic line concentric honeycomb 3dhoneycomb gyroid hilbertcurve archimedeanchords "
    "octagramspiral adaptivecubic supportcubic lightning",
    "slic3r": "rectilinear alignedrectilinear grid triangles stars cubic concentric honeycomb 3dhoneycomb hilbertcurve archimedeanchords octagramspiral",
    "cura": "grid lines triangles trihexagon cubic cubicsubdiv tetrahedral quarter_cubic concentric zigzag cross cross_3d gyroid lightning",
}

# Name, words of PrusaSlicer, of Slic3r where they differ ("-": it has none), of CuraEngine ("-" again).
SETTINGS = [
    ("as the profile has it", "perimeters = 2", "", "wall_line_count = 2"),
    ("walls of any width", "perimeter_generator = arachne", "-", "fill_outline_gaps = true"),
    ("walls of one width", "perimeter_generator = classic", "-", "fill_outline_gaps = false"),
    ("outer walls first", "external_perimeters_first = 1", "", "outer_inset_first = true\ninset_direction = outside_in"),
    ("ironing", "ironing = 1", "-", "ironing_enabled = true"),
    ("ironing of all solid layers", "ironing = 1\nironing_type = solid", "-", "-"),
    ("first layer narrower", "elefant_foot_compensation = 0.2", "-", "xy_offset_layer_0 = -0.2"),
    ("0.1 mm wider", "xy_size_compensation = 0.1", "", "xy_offset = 0.1"),
    ("0.1 mm narrower", "xy_size_compensation = -0.1", "", "xy_offset = -0.1"),
    ("raft", "raft_layers = 2", "", "adhesion_type = raft"),
    ("brim", "brim_width = 4", "", "adhesion_type = brim\nbrim_width = 4"),
    ("supports", "support_material = 1\nsupport_material_auto = 1", "", "support_enable = true\nsupport_type = everywhere"),
    ("wipes", "wipe = 1\nretract_before_wipe = 70%", "", "-"),
    ("layers of 0.1 mm", "layer_height = 0.1\nfirst_layer_height = 0.2", "", "layer_height = 0.1\nlayer_height_0 = 0.2"),
    ("layers of 0.15 mm", "layer_height = 0.15\nfirst_layer_height = 0.2", "", "layer_height = 0.15\nlayer_height_0 = 0.2"),
    ("layers of 0.3 mm", "layer_height = 0.3\nfirst_layer_height = 0.3", "", "layer_height = 0.3\nlayer_height_0 = 0.3"),
    ("one wall", "perimeters = 1", "", "wall_line_count = 1"),
    ("three walls", "perimeters = 3", "", "wall_line_count = 3"),
    ("five walls", "perimeters = 5", "", "wall_line_count = 5"),
    ("wide outer walls", "external_perimeter_extrusion_width = 0.6", "", "wall_line_width_0 = 0.6"),
    ("all lines 0.6 mm wide", "extrusion_width = 0.6\nexternal_perimeter_extrusion_width = 0.6\nperimeter_extrusion_width = 0.6\n"
     "infill_extrusion_width = 0.6\nsolid_infill_extrusion_width = 0.6\ntop_infill_extrusion_width = 0.6\nfirst_layer_extrusion_width = 0.6", "", "line_width = 0.6"),
    ("thin walls, gaps filled", "thin_walls = 1\ngap_fill_enabled = 1", "thin_walls = 1\ngap_fill = 1", "fill_outline_gaps = true\nfill_perimeter_gaps = everywhere"),
    ("infill every second layer", "infill_every_layers = 2", "", "infill_sparse_thickness = 0.4"),
    ("infill of 5 %", "fill_density = 5%", "", "infill_line_distance = 9"),
    ("infill of 60 %", "fill_density = 60%", "", "infill_line_distance = 0.75"),
    ("infill of 100 %", "fill_density = 100%\nfill_pattern = rectilinear", "", "infill_line_distance = 0.45"),
    ("no infill", "fill_density = 0%", "", "infill_line_distance = 0"),
    ("tops and bottoms concentric", "top_fill_pattern = concentric\nbottom_fill_pattern = concentric",
     "top_infill_pattern = concentric\nbottom_infill_pattern = concentric", "top_bottom_pattern = concentric\ntop_bottom_pattern_0 = concentric"),
    ("two solid layers", "top_solid_layers = 2\nbottom_solid_layers = 2", "", "top_layers = 2\nbottom_layers = 2"),
    ("eight solid layers", "top_solid_layers = 8\nbottom_solid_layers = 8", "", "top_layers = 8\nbottom_layers = 8"),
    ("no tops", "top_solid_layers = 0", "", "top_layers = 0"),
    ("seams at random", "seam_position = random", "", "z_seam_type = random"),
    ("seams in line", "seam_position = aligned", "", "z_seam_type = back"),
    ("walls crossed as little as can be", "avoid_crossing_perimeters = 1", "", "retraction_combing = all"),
    ("retracted where walls are crossed", "only_retract_when_crossing_perimeters = 1", "", "retraction_combing = off"),
    ("lifted at travels", "retract_lift = 0.4", "", "retraction_hop_enabled = true\nretraction_hop = 0.4"),
    ("retraction by the firmware", "use_firmware_retraction = 1", "", "machine_firmware_retract = true"),
    ("absolute E", "use_relative_e_distances = 0", "", "relative_extrusion = false"),
    ("thin bridges", "bridge_flow_ratio = 0.8", "", "bridge_settings_enabled = true"),
    ("5 % less filament", "extrusion_multiplier = 0.95", "", "material_flow = 95"),
    ("5 % more filament", "extrusion_multiplier = 1.05", "", "material_flow = 105"),
    ("more walls where it slopes", "extra_perimeters = 1\nensure_vertical_shell_thickness = 1", "", "alternate_extra_perimeter = true"),
    ("infill before walls", "infill_first = 1", "", "infill_before_walls = true"),
    ("infill far into walls", "infill_overlap = 50%", "", "infill_overlap = 50"),
    ("slow and cool", "slowdown_below_layer_time = 30\nmin_print_speed = 5", "", "cool_min_layer_time = 30\ncool_min_speed = 5"),
    ("accelerations", "default_acceleration = 800\nperimeter_acceleration = 500", "", "acceleration_enabled = true\njerk_enabled = true"),
    ("coasting", "-", "", "coasting_enable = true"),
    ("layers of many heights", "-", "", "adaptive_layer_height_enabled = true"),
    ("fuzzy skin", "fuzzy_skin = external", "-", "magic_fuzzy_skin_enabled = true"),
    ("spiral", "spiral_vase = 1", "", "magic_spiralize = true"),
    ("volumetric E", "use_volumetric_e = 1", "", "-"),
]


def settings(slicer):
    """Names and words of a slicer's settings."""
    family = {"cura": "cura", "slic3r": "slic3r"}.get(slicer, "prusa")
    for name, prusa, slic3r, cura in SETTINGS:
        words = {"prusa": prusa, "slic3r": slic3r or prusa, "cura": cura}[family]
        if words != "-":
            yield name, words
    for pattern in PATTERNS[family].split():
        yield "pattern " + pattern, f"infill_pattern = {pattern}" if family == "cura" else f"fill_pattern = {pattern}\nfill_density = 20%"


def outcome(code, document, there):
    """What came of it, in a word, and why."""
    findings = document.get("verify", {}).get("findings", [])
    if code == 0 and there:
        ignored = [warning for warning in document["warnings"] if "ignored" in warning]
        return ("verified without it", ignored[0]) if ignored else ("verified", "")
    if findings:
        return "rejected", findings[0]["rule"] + ": " + findings[0]["text"]
    return "refused", document.get("code", "") + ": " + (document.get("error") or document.get("summary", "no answer"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trunnion")
    parser.add_argument("models", nargs="+")
    parser.add_argument("--slicer", required=True)
    parser.add_argument("--machine", default="generic-ac")
    parser.add_argument("--only")
    parser.add_argument("--out")
    args = parser.parse_args()
    out = open(args.out, "w") if args.out else sys.stdout
    counts = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        config, output = os.path.join(folder, "own.ini"), os.path.join(folder, "out.gcode")
        print("model", "setting", "result", "why", sep="\t", file=out)
        for name, words in settings(args.slicer):
            if args.only and args.only not in name:
                continue
            with open(config, "w") as file:
                file.write(words + "\n")
            for model in args.models:
                command = [args.trunnion, "prepare", model, "-m", args.machine, "--slicer", args.slicer, "--slicer-config", config, "-o", output, "--json"]
                done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
                try:
                    document = json.loads(done.stdout)
                except ValueError:
                    document = {}
                result, why = outcome(done.returncode, document, os.path.exists(output))
                counts[result] += 1
                print(os.path.basename(model), name, result, why[:200], sep="\t", file=out, flush=True)
                for left in (output, output + ".stale"):
                    if os.path.exists(left):
                        os.remove(left)
    print(f"{args.slicer}: " + ", ".join(f"{count} {result}" for result, count in counts.most_common()))


if __name__ == "__main__":
    main()
