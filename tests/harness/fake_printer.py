#!/usr/bin/env python3
"""A printer on a pseudo-terminal, sharing no code with trunnion, for `trunnion send` to print to.

    fake_printer.py LINK LOG --protocol marlin|rrf|klipper|grbl [--faults]

Written from the firmwares' texts. Every accepted block is written to LOG without number and checksum. With --faults (Marlin):
every 41st answer is lost, every 53rd line is refused as if a byte had been wrong, every 67th comes too late, every 71st
answer comes in two pieces, and chatter comes in between. Ends on SIGTERM.
"""
import argparse
import os
import select
import signal
import sys
import time
import tty


def xor(data):
    value = 0
    for byte in data:
        value ^= byte
    return value


class Printer:
    def __init__(self, master, log, protocol, faults):
        self.master, self.log, self.protocol, self.faults = master, log, protocol, faults
        self.last = 0
        self.seen = 0
        self.answers = 0
        self.dropped = False

    def say(self, text):
        os.write(self.master, text.encode() + b"\n")

    def ok(self, text="ok"):
        self.answers += 1
        if self.faults and self.answers > 5:
            if self.answers % 41 == 0:
                return
            if self.answers % 67 == 0:
                self.say("echo:busy: processing")
                time.sleep(0.3)
            if self.answers % 71 == 0:
                os.write(self.master, text[:1].encode())
                time.sleep(0.05)
                self.say(text[1:])
                return
            if self.answers % 29 == 0:
                self.say(" T:20.00 /0.00 B:20.00 /0.00 @:0 B@:0")
        self.say(text)

    def accept(self, block):
        self.log.write(block + b"\n")
        self.log.flush()

    def run_block(self, block):
        if block.startswith(b"M105"):
            self.ok("ok T:20.00 /0.00 B:20.00 /0.00 @:0 B@:0")
        elif block.startswith(b"M115"):
            names = {"marlin": "FIRMWARE_NAME:Marlin 2.1.2.5 UUID:feed", "rrf": "FIRMWARE_NAME: RepRapFirmware for Duet 2"}
            if self.protocol == "klipper":
                self.ok("ok FIRMWARE_NAME:Klipper FIRMWARE_VERSION:v0.12")
                return
            self.say(names[self.protocol])
            self.ok()
        else:
            if block.startswith(b"M114"):
                self.say("X:0.00 Y:0.00 Z:0.00 A:0.00 C:0.00 E:0.00 Count X:0 Y:0 Z:0")
            self.accept(block)
            self.ok()

    def refuse(self, why):
        drain(self.master)
        self.dropped = True
        self.say("Error:%s, Last Line: %d" % (why, self.last))
        self.say("Resend: %d" % (self.last + 1))
        self.say("ok")

    def marlin(self, line):
        if not line:
            return
        if not line.startswith(b"N"):
            self.run_block(line)
            return
        digits = 1
        while digits < len(line) and line[digits : digits + 1].isdigit():
            digits += 1
        number = int(line[1:digits])
        renumber = b"M110" in line
        if renumber:
            number = int(line[line.index(b"M110") + 4 :].split(b"N")[1].split(b"*")[0])
        elif number != self.last + 1:
            if number not in (self.last, self.last - 1):
                self.refuse("Line Number is not Last Line Number+1")
            return
        if b"*" not in line:
            self.refuse("No Checksum with line number")
            return
        body, total = line.rsplit(b"*", 1)
        self.seen += 1
        spoilt = self.faults and self.seen % 53 == 0
        if int(total) != xor(body) or spoilt:
            self.refuse("checksum mismatch")
            return
        self.last = number
        self.run_block(body[digits:].strip())

    def rrf(self, line):
        body, _, total = line.rpartition(b"*")
        if line and int(total) == xor(body):
            digits = 1
            while body[digits : digits + 1].isdigit():
                digits += 1
            self.run_block(body[digits:].strip())

    def grbl(self, line):
        if line == b"$I":
            self.say("[VER:1.1h.20190830:]")
            self.say("[OPT:V,15,128]")
            self.ok()
            return
        if line:
            self.accept(line)
        self.ok()

    def take(self, line):
        getattr(self, {"klipper": "run_block"}.get(self.protocol, self.protocol))(line)


def drain(master):
    """Marlin throws its receive buffer away with every refusal."""
    while select.select([master], [], [], 0)[0]:
        os.read(master, 4096)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("link")
    parser.add_argument("log")
    parser.add_argument("--protocol", default="marlin")
    parser.add_argument("--faults", action="store_true")
    args = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    master, slave = os.openpty()
    tty.setraw(slave)
    if os.path.islink(args.link):
        os.unlink(args.link)
    os.symlink(os.ttyname(slave), args.link)
    with open(args.log, "wb") as log:
        printer = Printer(master, log, args.protocol, args.faults)
        pending = b""
        while True:
            data = os.read(master, 4096)
            if args.protocol == "grbl":
                for _ in range(data.count(b"?")):
                    printer.say("<Idle|MPos:0.000,0.000,0.000,0.000,0.000|Bf:15,128|FS:0,0>")
                data = data.replace(b"?", b"")
            pending += data
            while b"\n" in pending:
                line, pending = pending.split(b"\n", 1)
                printer.take(line.strip())
                if printer.dropped:
                    printer.dropped, pending = False, b""


if __name__ == "__main__":
    main()
