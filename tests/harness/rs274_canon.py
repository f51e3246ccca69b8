"""Runs an RS274/NGC program through LinuxCNC's own interpreter and prints its canonical moves, one JSON document a line.

Usage: rs274_canon.py PROGRAM PARAMETERS AXES      (PARAMETERS: a .var file, may be empty; AXES: for example XYZACU)

The interpreter is the one of the `rs274` command. That command is built for X Y Z A B C alone and refuses the U word of
our extruder, so the `gcode` module of the same package is used, which asks its caller which axes there are.
A refused program ends with exit code 1 and the interpreter's words on stderr.
"""

import json
import sys

import gcode

LETTERS = "XYZABCUVW"
# The module hands over inches, whatever the program's unit.
MM = [25.4, 25.4, 25.4, 1.0, 1.0, 1.0, 25.4, 25.4, 25.4]


class Canon(object):
    def __init__(self, parameter_file, axes):
        self.parameter_file = parameter_file
        self.mask = sum(1 << LETTERS.index(letter) for letter in axes)
        self.line = 0
        self.feed = 0.0
        self.shift = [0.0] * 9

    def __getattr__(self, name):
        # Canonical calls that do not move: tool, spindle, coolant, comments.
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *arguments: None

    def next_line(self, state):
        self.line = state.sequence_number

    def check_abort(self):
        return False

    def get_axis_mask(self):
        return self.mask

    def get_external_length_units(self):
        return 1.0 / 25.4

    def get_external_angular_units(self):
        return 1.0

    def get_block_delete(self):
        return False

    def get_tool(self, pocket):
        # Number, nine offsets, diameter, front and back angle, orientation: no tool.
        return (0,) + (0.0,) * 12 + (0,)

    def set_feed_rate(self, feed):
        # F is handed over in inches even where degrees are meant; times this it is F as written.
        self.feed = feed * 25.4

    def set_g92_offset(self, *shift):
        self.shift = list(shift)

    def move(self, kind, to):
        at = [(value + shift) * unit for value, shift, unit in zip(to, self.shift, MM)]
        print(json.dumps({"kind": kind, "line": self.line, "to": at, "feed": self.feed}))

    def straight_feed(self, *to):
        self.move("feed", to)

    def straight_traverse(self, *to):
        self.move("traverse", to)

    def arc_feed(self, x, y, centre_x, centre_y, turns, z, *rest):
        # Only the XY plane is written: first and second axis are X and Y.
        self.move("arc", (x, y, z) + rest)


def main():
    program, parameters, axes = sys.argv[1:]
    result, line = gcode.parse(program, Canon(parameters, axes), "", "")
    if result > gcode.MIN_ERROR:
        sys.stderr.write("line %d: %s\n" % (line, gcode.strerror(result)))
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
