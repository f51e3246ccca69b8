# Cura post-processing script: hands the sliced G-code to `trunnion rewrite` and gives Cura the 5-axis file back.
#
# Install: Help > Show Configuration Folder, copy this file into `scripts`, start Cura anew; then
# Extensions > Post Processing > Modify G-Code > Add a script > Trunnion.
#
# Cura only logs an exception of a script and saves the unchanged file, which on a machine whose table turns would be
# printed at the wrong pose. So nothing may escape from `execute`: whatever goes wrong, Cura gets a file without a
# single move.
#
# Works in Cura 4.13 and 5 (Python 3.7 and later), without other packages. MIT OR Apache-2.0.

import json
import os
import re
import shutil
import subprocess
import tempfile

try:
    from ..Script import Script
except ImportError:
    # A script folder that is loaded without its package.
    from Script import Script

try:
    from UM.Message import Message
except ImportError:
    Message = None

# Cura reads a layer in each entry that begins with this mark, and so do scripts behind this one.
LAYER = re.compile(r"^(?=;LAYER:)", re.MULTILINE)
# A display shows one short line.
DISPLAY_WIDTH = 48


class Refused(Exception):
    """The file cannot be rewritten; the text is for the user."""


class Trunnion(Script):
    def getSettingDataString(self):
        return json.dumps({
            "name": "Trunnion: 5-axis",
            "key": "Trunnion",
            "metadata": {},
            "version": 2,
            "settings": {
                "binary": {
                    "label": "trunnion",
                    "description": "The trunnion program: its full path, or its name where it is on the PATH.",
                    "type": "str",
                    "default_value": "trunnion",
                },
                "plan": {
                    "label": "Plan file",
                    "description": "Full path of the plan that `trunnion plan` wrote for this model.",
                    "type": "str",
                    "default_value": "",
                },
                "print_number": {
                    "label": "Print number",
                    "description": "Which print of the plan is on this plate, counted from 0. "
                                   "Empty: told by the object's name, as `trunnion slice` names it.",
                    "type": "str",
                    "default_value": "",
                },
                "timeout_s": {
                    "label": "Time-out",
                    "description": "Give up after so long; Cura does not answer meanwhile.",
                    "unit": "s",
                    "type": "int",
                    "default_value": 600,
                    "minimum_value": 1,
                },
            },
        })

    def execute(self, data):
        try:
            return LAYER.split(self.rewritten("".join(data)))
        except Refused as refusal:
            return unprintable(str(refusal))
        except Exception as error:
            return unprintable("%s: %s" % (type(error).__name__, error))

    def rewritten(self, gcode):
        binary = self.text("binary") or "trunnion"
        plan = self.text("plan")
        number = self.text("print_number")
        if not os.path.isfile(plan):
            raise Refused("no plan file %r; give its full path in the script's settings" % plan)
        if number and not number.isdigit():
            raise Refused("print number %r is not a whole number; leave it empty or count from 0" % number)
        folder = tempfile.mkdtemp(prefix="trunnion-")
        try:
            path = os.path.join(folder, "cura.gcode")
            # Bytes: a translated line end or a foreign character must come back as it went.
            sliced = gcode.encode("utf-8", "surrogateescape")
            with open(path, "wb") as file:
                file.write(sliced)
            command = [binary, "rewrite", "--in-place", "--plan", plan]
            if number:
                command += ["--print", number]
            run(command + [path], float(self.getSettingValueByKey("timeout_s") or 600))
            with open(path, "rb") as file:
                turned = file.read()
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        if not turned.strip() or turned == sliced:
            raise Refused("%s reported no error, but rewrote nothing; is it trunnion?" % binary)
        return turned.decode("utf-8", "surrogateescape")

    def text(self, key):
        value = self.getSettingValueByKey(key)
        return "" if value is None else str(value).strip()


def run(command, timeout_s):
    # Without this a console window flashes up on Windows.
    flags = getattr(subprocess, "CREATE_NO_WINDOW", 0)
    try:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   creationflags=flags)
    except OSError as error:
        raise Refused("cannot start %r: %s" % (command[0], error.strerror or error))
    try:
        said = process.communicate(timeout=timeout_s)[1].decode("utf-8", "replace").strip()
    except subprocess.TimeoutExpired:
        process.kill()
        raise Refused("no answer from trunnion within %g s" % timeout_s)
    if process.returncode != 0:
        raise Refused(said or "trunnion ended with exit code %d and said nothing" % process.returncode)


def unprintable(why):
    """A file without a move or a heater, and a message; Cura keeps it until the model is sliced again."""
    try:
        show(why)
    except Exception:
        # A window that cannot be shown must not let the sliced file through.
        pass
    lines = [";TRUNNION FAILED - this file prints nothing. Set it right, slice again, then save."]
    # One comment for each line: nothing of the message may become a command.
    lines += [";" + line for line in plain(why).splitlines()]
    first = (plain(why).splitlines() or [""])[0]
    lines.append("M117 trunnion: " + re.sub(r"[^A-Za-z0-9 .,:_/-]", " ", first)[:DISPLAY_WIDTH])
    return ["\n".join(lines) + "\n"]


def plain(text):
    return text.encode("ascii", "replace").decode("ascii")


def show(why):
    if Message is None:
        return
    text = why + "\n\nThe saved file prints nothing. Set it right, slice again, then save."
    kind = getattr(getattr(Message, "MessageType", None), "ERROR", None)
    options = {"message_type": kind} if kind is not None else {}
    Message(text, title="Trunnion", lifetime=0, **options).show()
