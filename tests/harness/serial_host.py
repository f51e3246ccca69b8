#!/usr/bin/env python3
"""An ordinary host over pyserial, sharing no code with trunnion: drives `trunnion simulate` through its port.

    serial_host.py PORT GCODE --protocol marlin|rrf|klipper|grbl [--spoil N]

Marlin and RepRapFirmware: numbers, XOR checksums, one line at a time. Klipper: plain lines. Grbl: character counting over
127 bytes. With --spoil every Nth line goes out first with a wrong byte (Marlin only), and the answer must be word for word
what the firmware says. Prints one JSON document; exit code 1 where an answer is not as it should be.
"""
import argparse
import json
import sys
import time

import serial

LIMIT = 60.0


def checksum(text):
    value = 0
    for byte in text.encode():
        value ^= byte
    return value


class Host:
    def __init__(self, port):
        self.port = serial.Serial(port, 115200, timeout=0.2, exclusive=True)
        self.until = time.monotonic() + LIMIT
        self.heard = []
        self.pending = b""

    def line(self):
        """The next line, or the harness ends: nothing here may hang."""
        while b"\n" not in self.pending:
            if time.monotonic() > self.until:
                sys.exit("no answer; the last lines were " + repr(self.heard[-5:]))
            self.pending += self.port.read(max(1, self.port.in_waiting))
        text, self.pending = self.pending.split(b"\n", 1)
        text = text.decode("ascii", "replace").rstrip("\r")
        self.heard.append(text)
        return text

    def until_ok(self):
        got = []
        while True:
            text = self.line()
            got.append(text)
            if text == "ok" or text.startswith("ok "):
                return got
            if text.startswith(("error:", "ALARM:", "!!")):
                sys.exit("refused: " + text)

    def send(self, text):
        self.port.write((text + "\n").encode())


def numbered(number, block):
    body = "N%d %s" % (number, block)
    return "%s*%d" % (body, checksum(body))


def marlin(host, blocks, spoil, rrf):
    if not rrf:
        host.send(numbered(0, "M110 N0"))
        host.until_ok()
    refused = 0
    for number, block in enumerate(blocks, 1):
        if spoil and number % spoil == 0:
            good = numbered(number, block)
            host.send(good.replace(block[0], chr(ord(block[0]) ^ 1), 1))
            got = host.until_ok()
            want = ["Error:checksum mismatch, Last Line: %d" % (number - 1), "Resend: %d" % number, "ok"]
            if got[-3:] != want:
                sys.exit("after a wrong byte: %r instead of %r" % (got, want))
            refused += 1
        host.send(numbered(number, block))
        host.until_ok()
    if rrf:
        return {"refused": 0}
    # A number that is skipped, one without its sum, one that it has already.
    last = len(blocks)
    host.send(numbered(last + 5, "M105"))
    skipped = host.until_ok()[-3:]
    if skipped != ["Error:Line Number is not Last Line Number+1, Last Line: %d" % last, "Resend: %d" % (last + 1), "ok"]:
        sys.exit("after a skipped number: %r" % skipped)
    host.send("N%d M105" % (last + 1))
    bare = host.until_ok()[-3:]
    if bare != ["Error:No Checksum with line number, Last Line: %d" % last, "Resend: %d" % (last + 1), "ok"]:
        sys.exit("without a checksum: %r" % bare)
    host.send(numbered(last, blocks[-1]))
    host.send(numbered(last + 1, "M105"))
    answer = host.until_ok()
    if len(answer) != 1 or not answer[0].startswith("ok T:"):
        sys.exit("a line that it has already should be dropped without a word: %r" % answer)
    host.send("M114")
    place = [t for t in host.until_ok() if t.startswith("X:")]
    return {"refused": refused, "place": place[0] if place else ""}


def klipper(host, blocks):
    for block in blocks:
        host.send(block)
        host.until_ok()
    for text in ["", "; a comment", "N7 M105*1"]:
        host.send(text)
        if len([t for t in host.until_ok() if t.startswith("ok")]) != 1:
            sys.exit("every line has exactly one ok: %r" % text)
    return {}


def grbl(host, blocks):
    host.send("$H")
    host.until_ok()
    host.send("$I")
    if not any(t.startswith("[OPT:") for t in host.until_ok()):
        sys.exit("$I says nothing of its buffers")
    flight = []
    for block in blocks:
        while sum(flight) + len(block) + 1 > 127:
            host.until_ok()
            flight.pop(0)
        host.send(block)
        flight.append(len(block) + 1)
    for _ in flight:
        host.until_ok()
    while True:
        host.port.write(b"?")
        text = host.line()
        if text.startswith("<Idle|MPos:"):
            return {"place": text}
        time.sleep(0.02)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("port")
    parser.add_argument("gcode")
    parser.add_argument("--protocol", default="marlin")
    parser.add_argument("--spoil", type=int, default=0)
    args = parser.parse_args()
    with open(args.gcode, encoding="ascii") as file:
        lines = [text.split(";")[0].strip() for text in file]
    blocks = [text for text in lines if text]
    host = Host(args.port)
    if args.protocol == "klipper":
        done = klipper(host, blocks)
    elif args.protocol == "grbl":
        done = grbl(host, blocks)
    else:
        done = marlin(host, blocks, args.spoil, args.protocol == "rrf")
    done["sent"] = len(blocks)
    print(json.dumps(done))


if __name__ == "__main__":
    main()
