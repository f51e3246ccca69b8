#!/usr/bin/python3
"""Runs a program on LinuxCNC's task controller, its motion controller and a HAL of nothing but joints, without a window.

Usage: linuxcnc_print.py PROGRAM FOLDER SECONDS      (FOLDER: empty, for the configuration, the log and the message files)

The machine is the installed sample `xyzac-trt.ini` (kinematics, axes, limits, the remapped M428 and M429) with three things
exchanged: a sixth joint for the filament (U), no window, and speed: every velocity, acceleration and the feed override are
far above the sample's, since a print in its own time would take hours. Where joints are does not depend on that.

What HAL is told is written down each servo period: FOLDER/joints.log has a line per period in which anything changed,
`LINE X Y Z A C U` (the program's line in motion, joints in mm and degrees). Exit codes: 0 the program ended by itself, 1 it
did not (words on stderr), 77 this machine cannot run LinuxCNC (why on stderr).
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import time

SAMPLE = "/usr/share/doc/linuxcnc/examples/sample-configs/sim/axis/vismach/5axis/table-rotary-tilting"
CANNOT = 77
NOBODY = 65534
JOINTS = 6
# mm/s or deg/s, per second squared for the second. Joints go through a cubic between the places of servo periods, which rounds a
# stop off by a sixth of what the acceleration makes in one period: 0.00033 mm here.
FAST, SHARP = 2000, 50000
# The servo period, ns.
PERIOD = 200000
# What the file's F is multiplied by.
OVERRIDE = 1000

AXIS_U = """
[AXIS_U]
MIN_LIMIT = -1000000
MAX_LIMIT = 1000000
MAX_VELOCITY = 1
MAX_ACCELERATION = 1

[JOINT_5]
TYPE = LINEAR
HOME = 0
MAX_VELOCITY = 1
MAX_ACCELERATION = 1
MIN_LIMIT = -1000000
MAX_LIMIT = 1000000
HOME_SEARCH_VEL = 0
HOME_SEQUENCE = 0
"""

# Outputs are fed back as they are; every tool is there at once.
HAL = """
loadrt [KINS](KINEMATICS)
loadrt [EMCMOT](EMCMOT) servo_period_nsec=[EMCMOT](SERVO_PERIOD) num_joints=[KINS](JOINTS)
loadrt sampler depth=60000 cfg=sffffff
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf sampler.0 servo-thread
net line motion.program-line => sampler.0.pin.0
{joints}
net kins-select motion.analog-out-03 => motion.switchkins-type
setp xyzac-trt-kins.y-offset 20
setp xyzac-trt-kins.z-offset 10
net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
net prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared
net change iocontrol.0.tool-change => iocontrol.0.tool-changed
"""


class Cannot(Exception):
    """Why LinuxCNC's word cannot be had on this machine."""


def configuration(folder):
    """The sample's text with U, without a window, fast."""
    with open(os.path.join(SAMPLE, "xyzac-trt.ini")) as file:
        text = file.read()
    # Sections of a window, and HAL lines that draw the machine; their comment lines with them.
    text = "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("#"))
    for section in ("APPLICATIONS", "DISPLAY", "HAL", "HALUI"):
        text = re.sub(r"(?ms)^\[%s\].*?(?=^\[|\Z)" % section, "", text)
    text += AXIS_U
    for key, value in (
        ("COORDINATES", "XYZACU"),
        ("KINEMATICS", "xyzac-trt-kins sparm=identityfirst coordinates=XYZACU"),
        ("JOINTS", JOINTS),
        ("MAX_VELOCITY", FAST),
        ("MAX_ACCELERATION", SHARP),
        ("DEFAULT_LINEAR_VELOCITY", FAST),
        ("MAX_LINEAR_VELOCITY", FAST),
        ("DEFAULT_LINEAR_ACCELERATION", SHARP),
        ("MAX_LINEAR_ACCELERATION", SHARP),
        ("SERVO_PERIOD", PERIOD),
        ("SUBROUTINE_PATH", os.path.join(SAMPLE, "remap_subs")),
        ("TOOL_TABLE", os.path.join(folder, "tools.tbl")),
    ):
        text, count = re.subn(r"(?m)^(\s*%s\s*=).*$" % key, r"\g<1> %s" % value, text)
        if not count:
            raise Cannot("the sample configuration has no key %s" % key)
    # A line of the program per cycle is read ahead.
    text = re.sub(r"(?m)^(\[TASK\][^\[]*?CYCLE_TIME\s*=).*$", r"\g<1> 0.001", text)
    window = "[DISPLAY]\nDISPLAY = %s\nMAX_FEED_OVERRIDE = %d\n" % (os.path.join(folder, "window.py"), OVERRIDE)
    return text + window + "[HAL]\nHALFILE = %s\n" % os.path.join(folder, "joints.hal")


def write(folder, name, text):
    with open(os.path.join(folder, name), "w") as file:
        file.write(text)


def run():
    """LinuxCNC's "window": homes, runs the program to its end, and says how it went."""
    import linuxcnc

    folder, seconds = os.environ["HOME"], os.environ["PRINT_SECONDS"]
    log = open(os.path.join(folder, "samples"), "w")
    sampler = subprocess.Popen(["halsampler"], stdout=log)
    command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
    end = time.monotonic() + float(seconds)

    def reach(done, what):
        while True:
            status.poll()
            said = errors.poll()
            if said and said[0] in (linuxcnc.NML_ERROR, linuxcnc.OPERATOR_ERROR):
                raise SystemExit("line %d: %s" % (status.motion_line, said[1]))
            if done():
                return
            if time.monotonic() > end:
                raise SystemExit("not %s within %s s, at line %d" % (what, seconds, status.motion_line))
            time.sleep(0.01)

    try:
        command.state(linuxcnc.STATE_ESTOP_RESET)
        command.state(linuxcnc.STATE_ON)
        reach(lambda: status.task_state == linuxcnc.STATE_ON, "switched on")
        command.mode(linuxcnc.MODE_MANUAL)
        command.wait_complete()
        command.home(-1)
        reach(lambda: all(status.homed[:JOINTS]), "homed")
        command.feedrate(OVERRIDE)
        command.mode(linuxcnc.MODE_AUTO)
        command.wait_complete()
        command.program_open(os.path.join(folder, "print.ngc"))
        command.auto(linuxcnc.AUTO_RUN, 0)
        reach(lambda: status.interp_state != linuxcnc.INTERP_IDLE, "started")
        reach(lambda: status.interp_state == linuxcnc.INTERP_IDLE and status.inpos, "ended")
        time.sleep(0.3)
        write(folder, "ended", "by itself\n")
    except SystemExit as failure:
        write(folder, "failed", str(failure) + "\n")
    finally:
        sampler.send_signal(signal.SIGINT)
        sampler.wait()
        log.close()


def changes(folder):
    """Of the samples only those that differ from the one before."""
    before = None
    with open(os.path.join(folder, "samples")) as samples, open(os.path.join(folder, "joints.log"), "w") as log:
        for sample in samples:
            if sample.startswith("overrun"):
                raise Cannot("samples were lost: this machine is too slow")
            if sample != before:
                log.write(sample)
                before = sample


def start(folder, seconds):
    """Runs LinuxCNC until its window is done; its own message files go into the folder as well."""
    who = {}
    if os.getuid() == 0:
        # It refuses to run as root.
        who = dict(user=NOBODY, group=NOBODY, extra_groups=[])
        for name in ["."] + os.listdir(folder):
            os.chown(os.path.join(folder, name), NOBODY, NOBODY)
    with open(os.path.join(folder, "linuxcnc.out"), "w") as out:
        child = subprocess.Popen(
            ["linuxcnc", "-r", os.path.join(folder, "print.ini")],
            cwd=folder,
            env=dict(os.environ, HOME=folder, PRINT_SECONDS=str(seconds)),
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            **who
        )
        try:
            child.wait(seconds + 30)
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, signal.SIGKILL)
            raise Cannot("LinuxCNC did not end within %s s" % (seconds + 30))


def main():
    program, folder, seconds = sys.argv[1], os.path.abspath(sys.argv[2]), float(sys.argv[3])
    if not shutil.which("linuxcnc"):
        sys.stderr.write("LinuxCNC is not installed (apt-get install linuxcnc-uspace)\n")
        return CANNOT
    if not os.path.exists(os.path.join(SAMPLE, "xyzac-trt.ini")):
        sys.stderr.write("LinuxCNC's sample configurations are not installed (%s)\n" % SAMPLE)
        return CANNOT
    if os.path.exists("/tmp/linuxcnc.lock"):
        sys.stderr.write("LinuxCNC runs already, or its /tmp/linuxcnc.lock was left behind\n")
        return CANNOT
    nets = ["net j%d joint.%d.motor-pos-cmd => joint.%d.motor-pos-fb sampler.0.pin.%d" % (n, n, n, n + 1) for n in range(JOINTS)]
    write(folder, "joints.hal", HAL.format(joints="\n".join(nets)))
    write(folder, "tools.tbl", "")
    write(folder, "print.ini", configuration(folder))
    shutil.copy(program, os.path.join(folder, "print.ngc"))
    shutil.copy(__file__, os.path.join(folder, "window.py"))
    os.chmod(os.path.join(folder, "window.py"), 0o755)
    start(folder, seconds)
    failed, ended = (os.path.join(folder, name) for name in ("failed", "ended"))
    if os.path.exists(failed):
        sys.stderr.write(open(failed).read())
        return 1
    if not os.path.exists(ended):
        sys.stderr.write("LinuxCNC does not start here: see what it said\n" + open(os.path.join(folder, "linuxcnc.out")).read())
        return CANNOT
    changes(folder)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(run() if sys.argv[1:2] == ["-ini"] else main())
    except Cannot as reason:
        sys.stderr.write("%s\n" % reason)
        sys.exit(CANNOT)
