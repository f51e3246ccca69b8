#!/usr/bin/env python3
"""OctoPrint's own virtual printer, as it is, on a pseudo-terminal for `trunnion send` to print to.

    octoprint_printer.py LINK LOG [--errors]

Needs the package OctoPrint (1.11). Every command that it carries out is written to LOG. With --errors its simulated wire errors
come at the lines that its defaults say, but for resend_with_timeout, which counts a line that is never carried out; else none.
Ends on SIGTERM.
"""
import argparse
import logging
import os
import signal
import tempfile
import threading
import tty

logging.disable(logging.CRITICAL)

import octoprint.plugin


class NoPlugins:
    def get_hooks(self, *_):
        return {}


octoprint.plugin.plugin_manager = lambda *_, **__: NoPlugins()

from octoprint.plugins.virtual_printer import VirtualPrinterPlugin
from octoprint.plugins.virtual_printer.virtual import VirtualPrinter


class Settings:
    """The plugin's defaults."""

    def __init__(self, values):
        self.values = values

    def get(self, path, **_):
        value = self.values
        for key in path:
            value = value.get(key) if isinstance(value, dict) else None
        return value

    def get_boolean(self, path, **_):
        return bool(self.get(path))

    def get_int(self, path, **_):
        return int(self.get(path))

    def get_float(self, path, **_):
        return float(self.get(path))

    def global_get_basefolder(self, *_, **__):
        return tempfile.mkdtemp()


class Profiles:
    def get_current_or_default(self):
        speeds = {axis: {"speed": 6000, "inverted": False} for axis in "xyze"}
        volume = {"width": 300, "depth": 300, "height": 300, "formFactor": "rectangular", "origin": "center", "custom_box": False}
        extruder = {"count": 1, "sharedNozzle": False, "offsets": [(0, 0)]}
        return {"axes": speeds, "volume": volume, "heatedBed": True, "heatedChamber": False, "extruder": extruder}


class Printer(VirtualPrinter):
    """Writes down what it carries out."""

    log = None

    def _gcode_G(self, _code, data):
        print(data, file=self.log, flush=True)
        return False

    _gcode_M = _gcode_G


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("link")
    arguments.add_argument("log")
    arguments.add_argument("--errors", action="store_true")
    given = arguments.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: os._exit(0))
    values = VirtualPrinterPlugin().get_settings_defaults()
    # Faster than in a browser; everything else is as it comes.
    values["throttle"] = 0.0001
    errors = [error for error in values["simulated_errors"] if "timeout" not in error]
    values["simulated_errors"] = errors if given.errors else []
    Printer.log = open(given.log, "w")
    printer = Printer(Settings(values), Profiles(), tempfile.mkdtemp(), read_timeout=0.5)
    master, slave = os.openpty()
    tty.setraw(slave)
    os.symlink(os.ttyname(slave), given.link)

    def answers():
        while True:
            line = printer.readline()
            if line:
                os.write(master, line if line.endswith(b"\n") else line + b"\n")

    threading.Thread(target=answers, daemon=True).start()
    held = b""
    while True:
        held += os.read(master, 4096)
        *lines, held = held.split(b"\n")
        for line in lines:
            if line.strip():
                printer.write(line + b"\n")


main()
