"""Runs a Cura post-processing script outside Cura, as Cura does when a file is saved.

Usage: cura_harness.py SCRIPT IN.gcode OUT.gcode [--set KEY=VALUE ..] [--forget KEY] [--no-messages]

Like Cura: the script is loaded as a module of the package that holds `Script`, its class is named as its file, settings
come from `getSettingDataString()` with their types and defaults, the G-code is handed over as header, start code, one
entry for each `;LAYER:n` and end code, and an exception is only logged while the unchanged G-code is saved.

stderr: `MESSAGE: ..` for what the user would be shown, `EXCEPTION: ..` for what Cura would log.
`--forget` makes the asking for a setting raise, for a fault that no script foresees;
`--no-messages` makes showing a message raise, as it does where Cura has no window.
"""

import argparse
import importlib.util
import json
import os
import re
import sys
import types
from collections import OrderedDict

PACKAGE = "PostProcessingPlugin"


def fake_cura(values, no_messages):
    """The modules that a script may import, as far as this project's scripts use them."""

    class Script(object):
        def getSettingDataString(self):
            raise NotImplementedError()

        def getSettingData(self):
            return json.loads(self.getSettingDataString(), object_pairs_hook=OrderedDict)

        def getSettingValueByKey(self, key):
            return values[key]

        def execute(self, data):
            raise NotImplementedError()

    class Message(object):
        def __init__(self, text="", lifetime=30, title=None, **more):
            self.text = text

        def show(self):
            if no_messages:
                raise RuntimeError("no window")
            sys.stderr.write("MESSAGE: %s\n" % self.text.replace("\n", " | "))

    def module(name, package=False, **names):
        made = types.ModuleType(name)
        if package:
            made.__path__ = []
        made.__dict__.update(names)
        sys.modules[name] = made

    module(PACKAGE, package=True)
    module(PACKAGE + ".Script", Script=Script)
    # Cura loads scripts below the module of the plug-in's main class, which bears the package's name.
    module(PACKAGE + "." + PACKAGE, package=True)
    module("UM", package=True)
    module("UM.Message", Message=Message)


def load(path):
    """An object of the script's class."""
    name = os.path.splitext(os.path.basename(path))[0]
    spec = importlib.util.spec_from_file_location("%s.%s.%s" % (PACKAGE, PACKAGE, name), path)
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[name] = loaded
    spec.loader.exec_module(loaded)
    return getattr(loaded, name)()


def settings(script, given):
    """Defaults of the script's own document, then what was given, in the declared types."""
    document = script.getSettingData()
    for key in ("name", "key", "metadata", "version", "settings"):
        assert key in document, "the settings lack %r" % key
    assert document["version"] == 2 and document["key"] == type(script).__name__
    types_of = {"str": str, "int": int, "float": float, "bool": lambda text: text == "True", "enum": str}
    values = {}
    for key, setting in document["settings"].items():
        assert "label" in setting and "description" in setting, "%s lacks a label or a description" % key
        values[key] = setting["default_value"]
        if key in given:
            values[key] = types_of[setting["type"]](given.pop(key))
    assert not given, "no such setting: %s" % ", ".join(given)
    return values


def split(gcode):
    """G-code as CuraEngine's back end hands it over."""
    entries = re.split(r"(?m)^(?=;LAYER:)", gcode)
    first_command = re.search(r"(?m)^[^;\s]", entries[0])
    cut = first_command.start() if first_command else len(entries[0])
    layers, end = entries[1:], ""
    if layers:
        # The last layer ends with its time; behind it comes the end code.
        body, mark, rest = layers[-1].rpartition(";TIME_ELAPSED:")
        line, newline, end = rest.partition("\n")
        if mark:
            layers[-1] = body + mark + line + newline
        else:
            end = ""
    return [entries[0][:cut], entries[0][cut:]] + layers + ([end] if end else [])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("script")
    parser.add_argument("input")
    parser.add_argument("output")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--forget", metavar="KEY")
    parser.add_argument("--no-messages", action="store_true")
    options = parser.parse_args()

    values = {}
    fake_cura(values, options.no_messages)
    script = load(options.script)
    values.update(settings(script, dict(pair.split("=", 1) for pair in options.set)))
    values.pop(options.forget, None)
    with open(options.input, encoding="utf-8", errors="surrogateescape", newline="") as file:
        data = split(file.read())
    if ";POSTPROCESSED" not in data[0]:
        try:
            changed = script.execute(list(data))
            assert isinstance(changed, list) and all(isinstance(entry, str) for entry in changed)
            data = changed
        except Exception as error:
            sys.stderr.write("EXCEPTION: %r\n" % error)
        data[0] += ";POSTPROCESSED\n"
    with open(options.output, "w", encoding="utf-8", errors="surrogateescape", newline="") as file:
        for entry in data:
            file.write(entry)
    return 0


if __name__ == "__main__":
    sys.exit(main())
