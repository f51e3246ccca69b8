"""A print streamed by `trunnion send`, by printcore (Printrun) and by OctoPrint's own sender, to the same simulated printer.

    cargo build --release
    python3 -m venv /tmp/hosts
    /tmp/hosts/bin/pip install pyserial psutil platformdirs OctoPrint && /tmp/hosts/bin/pip install --no-deps Printrun
    /tmp/hosts/bin/python benches/compare/send_hosts.py target/release/trunnion [LINES]

Prints a line of JSON a host: {"host", "version", "lines", "lines_per_s", "cpu_us_a_line", "printer_cpu_us_a_line"}. The printer is `trunnion
simulate --speed max` behind a pseudo-terminal without a baud rate, with Marlin's 128 bytes and 4 commands, and writes down what it has executed:
a host that leaves out a line or sends one twice is told, and so is one that is not installed (SKIPPED). Processor time is that of the host's
process up to its end, start included; an empty print is taken off it.
"""

import json
import os
import subprocess
import sys
import tempfile
import time

BAUD = 115200


def moves(lines):
    text = ["G21", "G90", "M83", "G28", "M109 S200", "G1 F12000"]
    for i in range(lines):
        x = i % 200 * 0.1
        text.append(f"G1 X{x:.3f} Y{50.125 + x:.3f} Z10.205 A31.125 C120.{i % 1000:03} E{0.004 + i * 1e-7:.7f}")
    return text


def printcore(port, path):
    from printrun import gcoder
    from printrun.printcore import printcore as Host

    host = Host(port, BAUD)
    while not host.online:
        time.sleep(0.01)
    host.startprint(gcoder.LightGCode([line.rstrip("\n") for line in open(path)]))
    while host.printing:
        time.sleep(0.01)
    # It ends when all is sent; the last answers are still to come.
    while host.clear is False:
        time.sleep(0.01)
    host.disconnect()


def octoprint(port, path):
    import octoprint.plugin
    from octoprint.settings import settings

    settings(init=True, basedir=tempfile.mkdtemp())
    octoprint.plugin.plugin_manager(init=True, plugin_folders=[], plugin_bases=[], plugin_entry_points=[])
    from octoprint.printer.profile import PrinterProfileManager
    from octoprint.util.comm import MachineCom, MachineComPrintCallback

    host = MachineCom(
        port, BAUD, callbackObject=MachineComPrintCallback(), printerProfileManager=PrinterProfileManager()
    )
    host.start()
    while not host.isOperational():
        time.sleep(0.01)
        if host.isError():
            sys.exit(host.getErrorString())
    host.selectFile(path, False, user=None)
    host.startPrint()
    while host.isPrinting() or host.isFinishing():
        time.sleep(0.01)
    host.close()


def trunnion(port, path):
    sys.exit("started by itself")


HOSTS = {"trunnion": trunnion, "printcore": printcore, "octoprint": octoprint}


def version(name):
    if name == "trunnion":
        return ""
    from importlib.metadata import version as of

    return of({"printcore": "Printrun", "octoprint": "OctoPrint"}[name])


def executed(log):
    """The moves that the printer has executed, without blanks and padding."""
    lines = []
    for line in open(log):
        words = line.split(" ", 2)
        if len(words) > 2 and words[1] == "line" and "X" in words[2]:
            at = words[2].index("E") + 1
            lines.append(float(words[2][at:]))
    return lines


def once(name, command, lines, folder):
    path, port, log = (os.path.join(folder, n) for n in ("a.gcode", "tty", "log"))
    text = moves(lines)
    open(path, "w").write("\n".join(text) + "\n")
    for old in (port, log):
        if os.path.lexists(old):
            os.remove(old)
    with open(os.path.join(folder, "err"), "w") as err:
        simulate = [command, "simulate", "-q", "--speed", "max", "--heat", "1000", "-m", "generic-ac", "--link", port, "--log", log]
        printer = subprocess.Popen(simulate, stderr=err)
        while not os.path.exists(port):
            time.sleep(0.01)
        if name == "trunnion":
            host = [command, "send", "-q", "--unverified", "-m", "generic-ac", "--port", port, path]
        else:
            host = [sys.executable, __file__, "--host", name, port, path]
        began = time.monotonic()
        child = subprocess.Popen(host, stdout=subprocess.DEVNULL, stderr=err)
        _, status, used = os.wait4(child.pid, 0)
        seconds = time.monotonic() - began
        # What has arrived is carried out.
        time.sleep(1)
        printer.terminate()
        _, _, printing = os.wait4(printer.pid, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"{name} failed: " + open(os.path.join(folder, "err")).read()[-500:])
    found = executed(log)
    wanted = [float(f"{0.004 + i * 1e-7:.7f}") for i in range(lines)]
    if found != wanted:
        print(f"{name}: {len(found)} of {len(wanted)} lines executed, not as they were sent", file=sys.stderr)
    cpu = used.ru_utime + used.ru_stime
    return seconds, cpu, printing.ru_utime + printing.ru_stime


def main():
    if sys.argv[1] == "--host":
        HOSTS[sys.argv[2]](sys.argv[3], sys.argv[4])
        os._exit(0)
    command = os.path.abspath(sys.argv[1])
    lines = int(sys.argv[2]) if len(sys.argv) > 2 else 5000
    for name in HOSTS:
        try:
            known = version(name)
        except ImportError:
            print(f"SKIPPED {name}: not installed for {sys.executable}", file=sys.stderr)
            continue
        with tempfile.TemporaryDirectory() as folder:
            empty, full = once(name, command, 1, folder), once(name, command, lines, folder)
        seconds, cpu, printer = (b - a for a, b in zip(empty, full))
        figures = {"lines_per_s": round(lines / seconds), "cpu_us_a_line": round(cpu / lines * 1e6, 1)}
        figures["printer_cpu_us_a_line"] = round(printer / lines * 1e6, 1)
        print(json.dumps({"host": name, "version": known, "lines": lines, **figures}), flush=True)


main()
