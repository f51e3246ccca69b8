"""Programs to printers: `send` to the simulated printer of the command, `publish` to a small OctoPrint on this computer.

A printer's log and a server's files are what counts: what was executed, what was kept, and what was never asked for.
"""

import contextlib
import hashlib
import http.server
import json
import logging
import os
import pickle
import re
import signal
import subprocess
import threading
import time
import traceback
import unittest
import warnings
from pathlib import Path

import trunnion
from shared import COMMAND, Folder, command, fixture, untimed

#: A machine that somebody has looked at, and that can home with a part on its table.
MACHINE = """extends = "generic-ac"
[machine]
name = "bench"
jogged = "2026-01-01"
jogged_as = "bench: A about X +1, level at 0; C +1"
[head]
measured = true
[link]
rehome = "G28"
"""
#: What printers are asked beside the program.
OWN = ("M105", "M110", "M115", "M400", "M114")
#: For what hangs alone.
PATIENCE_S = 300


def moves(count, feed=3000, across=7):
    """A program of `count` moves in layers, every one another."""
    lines = ["G21", "G90", "M83", "G28", "G1 A0 F600", "G1 C0 F600", "M104 S200", "M109 S200", f"G1 F{feed}"]
    for i in range(count):
        if i % 40 == 0:
            lines += [";LAYER_CHANGE", f"G1 Z{1 + i * 0.005:.4f}"]
        lines.append(f"G1 X{i % across} Y{i * 0.001:.3f} E{0.02 + i * 1e-5:.5f}")
    return "\n".join(lines) + "\n"


def plain(line):
    """A block's words, so that both ways of writing numbers are equal."""
    return tuple((letter, float(number or 0)) for letter, number in re.findall(r"([A-Z])(-?[0-9.]*)", line.split(";")[0]))


def wanted(program):
    return [plain(line) for line in program.splitlines() if line.strip() and not line.startswith(";")]


class Printer:
    """The command's simulated printer behind `link`; its log is read while it works."""

    def __init__(self, test, machine, *flags, name="tty"):
        self.link, self.log = test.folder / name, test.folder / f"{name}.log"
        words = ["simulate", "-q", "--heat", "50", "-m", machine, "--link", self.link, "--log", self.log, *flags]
        self.process = subprocess.Popen([COMMAND, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        test.addCleanup(self.process.wait)
        test.addCleanup(self.process.kill)
        until = time.monotonic() + PATIENCE_S
        while not self.link.exists():
            test.assertLess(time.monotonic(), until, "no printer")
            time.sleep(0.01)

    def executed(self):
        """The program's blocks that it executed."""
        lines = [line.partition(" line ")[2] for line in self.log.read_text().splitlines() if " line " in line]
        return [plain(line) for line in lines if not line.startswith(OWN)]

    def was_stopped(self):
        return " killed" in self.log.read_text()


class Printed(Folder):
    def setUp(self):
        super().setUp()
        self.machine = self.folder / "bench.toml"
        self.machine.write_text(MACHINE)

    def program(self, text):
        path = self.folder / "part.gcode"
        path.write_text(text)
        return path

    def prepared(self):
        model = trunnion.Model.from_arrays(*small())
        model.write(self.folder / "small.3mf")
        out, plan = self.folder / "small.gcode", self.folder / "small.json"
        return trunnion.prepare(self.folder / "small.3mf", self.machine, slicer="builtin", output=out, plan_out=plan)


def small():
    from shared import box

    return box((0, 0, 0), (6, 6, 1))


class Rehearsed(Printed):
    def test_a_rehearsal_is_the_commands(self):
        done = self.prepared()
        code, document, said = command("send", done.output, "--plan", self.folder / "small.json", "--dry-run")
        self.assertEqual(code, 0, said)
        for given in [(done,), (done.output, self.folder / "small.json"), (done.gcode, done.plan_file)]:
            more = {"model": self.folder / "small.3mf", "profile": self.machine} if given[0] is done.gcode else {}
            rehearsed = trunnion.send(*given, dry_run=True, **more)
            self.assertEqual(rehearsed.to_dict(), document)
            self.assertIsInstance(rehearsed, trunnion.Rehearsal)
        self.assertTrue(rehearsed.clean and rehearsed.seconds > rehearsed.seconds_print > 0)
        self.assertEqual(pickle.loads(pickle.dumps(rehearsed)), rehearsed)

    def test_what_the_simulated_printer_does_not_execute(self):
        path = self.program("G28\nM83\nG1 X5 E5 F600\n")
        code, document, _ = command("send", path, "--unverified", "-m", self.machine, "--dry-run")
        with self.assertWarns(trunnion.TrunnionWarning):
            done = trunnion.send(path, dry_run=True, unverified=True, profile=self.machine)
        self.assertEqual((code, done.clean), (1, False))
        self.assertEqual(done.to_dict(), document)


class Refused(Printed):
    """Nothing of what is not proved goes anywhere, unless that is said."""

    def nothing_is_sent(self, *program, error, **keywords):
        """`keywords` are refused by `send` before its port is opened, and by `publish` before its server is asked."""
        asked = []
        with Server() as server:
            for verb, where in [(trunnion.send, {"port": self.folder / "none"}), (trunnion.publish, {"to": server.address})]:
                with self.subTest(verb=verb.__name__), self.assertRaises(error) as caught:
                    verb(*program, **where, **keywords)
                asked.append(caught.exception)
            self.assertEqual(server.asked, [])
        self.assertEqual(list(self.folder.glob("*.journal")), [])
        return asked

    def test_a_program_without_its_plan(self):
        path = self.program(moves(9))
        for error in self.nothing_is_sent(path, error=trunnion.InputError, profile=self.machine):
            self.assertEqual((error.exit, error.code), (2, "command/usage"))
        for error in self.nothing_is_sent(path, error=trunnion.InputError, profile=self.machine, unverified=3):
            self.assertEqual(error.code, "command/usage")
        self.nothing_is_sent(path, self.folder / "plan.json", error=trunnion.InputError, unverified=True)
        with self.assertRaises(trunnion.InputError), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            trunnion.send(path, unverified=True, port=self.folder / "none")

    def test_a_program_with_findings(self):
        done = self.prepared()
        lines = done.gcode.splitlines(True)
        Path(done.output).write_bytes(b"".join(lines[: len(lines) // 2]))
        code, document, _ = command("publish", done.output, "--plan", self.folder / "small.json", "--to", "octoprint:http://127.0.0.1:1")
        for error in self.nothing_is_sent(done.output, self.folder / "small.json", error=trunnion.RejectedError):
            self.assertEqual({key: value for key, value in error.to_dict().items() if key != "verify"}, document)
            self.assertEqual((error.exit, error.code), (code, "command/no"))
            self.assertTrue(error.findings)

    def test_what_a_printer_cannot_execute(self):
        path = self.program("G28\nG1 X5000 F600\n")
        run = subprocess.run(
            [COMMAND, "send", path, "--unverified", "-m", self.machine, "--dry-run", "--json"], capture_output=True, text=True
        )
        with self.assertRaises(trunnion.RejectedError) as caught, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            trunnion.send(path, unverified=True, profile=self.machine, dry_run=True)
        self.assertEqual((caught.exception.exit, caught.exception.to_dict()), (run.returncode, json.loads(run.stdout)))

    def test_words_that_do_not_go_together(self):
        path, port = self.program(moves(9)), self.folder / "none"
        for keywords in [
            {}, {"port": port, "from_line": 3}, {"port": port, "baud": -1}, {"port": port, "wait_s": -1}, {"port": port, "wait_s": "long"},
            {"port": 3}, {"port": port, "resume": True}, {"dry_run": True, "baud": 0},
        ]:  # fmt: skip
            with self.subTest(keywords=keywords), warnings.catch_warnings(), self.assertRaises(trunnion.InputError) as caught:
                warnings.simplefilter("ignore")
                trunnion.send(path, unverified=True, profile=self.machine, **keywords)
            self.assertTrue(caught.exception.code)
        # Bytes have no file that a journal could be beside.
        with self.assertRaises(trunnion.InputError):
            trunnion.send(path.read_bytes(), unverified=True, profile=self.machine, port=port)


class Sent(Printed):
    def send(self, path, printer, **keywords):
        """As it is, without the warning that nothing was proved."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", trunnion.TrunnionWarning)
            return trunnion.send(path, unverified=True, profile=self.machine, port=printer.link, **keywords)

    def test_a_prepared_program_is_printed(self):
        done, seen = self.prepared(), []
        printer = Printer(self, self.machine, "--speed", "max")
        with self.assertLogs("trunnion", level="DEBUG") as heard:
            sent = trunnion.send(done, port=printer.link, progress=seen.append)
        self.assertEqual(printer.executed(), wanted(done.gcode.decode()))
        events = [one.event for one in seen if one.kind == "event"]
        self.assertEqual((events[0]["event"], events[-1]["event"]), ("start", "done"))
        self.assertEqual(events[-1], sent.to_dict())
        self.assertEqual([one.text for one in seen if one.kind == "event"], [event["event"] for event in events])
        self.assertEqual((sent.line, sent.resends), (sent.of, 0))
        self.assertTrue((self.folder / "small.gcode.journal").exists())
        self.assertEqual(len(heard.records), len(seen))
        # The command's own last line of the same print.
        again = Printer(self, self.machine, "--speed", "max", name="again")
        words = ["send", done.output, "--plan", self.folder / "small.json", "--port", again.link, "--json", "--journal", self.folder / "j"]
        run = subprocess.run([COMMAND, *map(str, words)], capture_output=True, text=True)
        self.assertEqual((run.returncode, json.loads(run.stdout.splitlines()[-1])), (0, sent.to_dict()), run.stderr)

    def test_bytes_and_a_bad_wire(self):
        text = moves(120)
        printer = Printer(self, self.machine, "--speed", "max", "--fault", "corrupt:0.05", "--seed", "3")
        journal = self.folder / "own.journal"
        with self.assertWarns(trunnion.TrunnionWarning):
            sent = trunnion.send(text.encode(), unverified=True, profile=self.machine, port=str(printer.link), journal=journal)
        self.assertEqual(printer.executed(), wanted(text))
        self.assertGreater(sent.resends, 0)
        self.assertTrue(journal.exists())

    def test_a_port_that_is_not_there(self):
        path = self.program(moves(9))
        run = subprocess.run(
            [COMMAND, "send", path, "--unverified", "-m", self.machine, "--port", self.folder / "none", "--json"], capture_output=True, text=True
        )
        with self.assertRaises(trunnion.PrinterError) as caught, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            trunnion.send(path, unverified=True, profile=self.machine, port=self.folder / "none")
        self.assertEqual((caught.exception.exit, caught.exception.to_dict()), (run.returncode, json.loads(run.stdout)))

    def paused_by(self, ends, error):
        """A print that `ends` pauses; it is resumed, and every line was executed once."""
        text = moves(400)
        # Slow enough for some seconds, and as many events, before its end.
        path, printer = self.program(text), Printer(self, self.machine, "--speed", "8")

        def progress(one):
            if one.kind == "event" and one.done > 40:
                progress.calls += 1
                ends()

        progress.calls = 0
        with self.assertRaises(error) as caught:
            self.send(path, printer, progress=progress)
        # Whoever has raised is told nothing more.
        self.assertEqual(progress.calls, 1)
        cause = caught.exception.__cause__
        self.assertIsInstance(cause, trunnion.PrinterError)
        self.assertEqual((cause.exit, cause.code), (4, "job/printer"))
        before = printer.executed()
        self.assertTrue(40 < len(before) < len(wanted(text)) and not printer.was_stopped())
        sent = self.send(path, printer, resume=True)
        self.assertEqual(sent.line, sent.of)
        extra = [block for block in printer.executed() if block not in set(wanted(text))]
        done = [block for block in printer.executed() if block in set(wanted(text)) and block[0] == ("G", 1.0) and len(block) == 4]
        self.assertEqual(done, [block for block in wanted(text) if block[0] == ("G", 1.0) and len(block) == 4])
        # The way off the part and back.
        self.assertTrue(extra)

    def test_ctrl_c_pauses_above_the_part(self):
        self.paused_by(lambda: signal.raise_signal(signal.SIGINT), KeyboardInterrupt)

    def test_a_callback_that_raises_pauses_above_the_part(self):
        class Enough(Exception):
            pass

        def raises():
            raise Enough

        self.paused_by(raises, Enough)

    def test_ctrl_c_twice_is_an_emergency_stop(self):
        # Moves that last for minutes: no pause comes before the second signal does.
        path, printer = self.program(moves(60, feed=30, across=90)), Printer(self, self.machine, "--speed", "1")
        again = threading.Event()

        def second():
            again.wait(PATIENCE_S)
            time.sleep(0.5)
            os.kill(os.getpid(), signal.SIGINT)

        def progress(one):
            if one.kind == "event" and one.done > 12:
                again.set()
                signal.raise_signal(signal.SIGINT)

        thread = threading.Thread(target=second)
        thread.start()
        self.addCleanup(thread.join)
        with self.assertRaises(KeyboardInterrupt) as caught:
            self.send(path, printer, progress=progress)
        self.assertEqual(caught.exception.__cause__.code, "job/printer")
        self.assertTrue(printer.was_stopped())

    def test_before_the_printer_is_asked_a_call_is_taken_back(self):
        path, printer = self.program(moves(400)), Printer(self, self.machine, "--speed", "max")

        class Enough(Exception):
            pass

        def progress(one):
            # The warning that nothing was proved.
            self.assertEqual(one.kind, "warning")
            raise Enough

        with self.assertRaises(Enough) as caught:
            self.send(path, printer, progress=progress)
        self.assertIsNone(caught.exception.__cause__)
        self.assertEqual(printer.executed(), [])
        self.assertFalse(self.folder.joinpath("part.gcode.journal").exists())


class Server:
    """An OctoPrint of a few answers. `before` is called when an upload is whole, before it is answered."""

    def __init__(self, key=None, before=None):
        self.key, self.before = key, before or (lambda: None)
        self.files, self.asked, self.started = {}, [], 0
        server = self

        class Answers(http.server.BaseHTTPRequestHandler):
            def log_message(self, *_):
                pass

            def say(self, status, document):
                text = json.dumps(document).encode()
                with contextlib.suppress(ConnectionError):
                    self.send_response(status)
                    self.send_header("Content-Length", str(len(text)))
                    self.end_headers()
                    self.wfile.write(text)

            def known(self):
                path = self.path.partition("?")[0]
                server.asked.append((self.command, path))
                if server.key is not None and self.headers.get("X-Api-Key") != server.key:
                    self.say(403, {"error": "no"})
                    return None
                return path

            def do_GET(self):
                path = self.known()
                name = (path or "").rpartition("/")[2]
                if path is None:
                    return
                if path == "/api/version":
                    self.say(200, {"api": "0.1", "text": "OctoPrint 1.11.8"})
                elif path == "/api/files/local":
                    self.say(200, {"files": [], "free": 1 << 30})
                elif path == "/api/printer":
                    ready = not server.started
                    self.say(200, {"state": {"text": "", "flags": {"operational": True, "ready": ready, "printing": not ready}}})
                elif path.startswith("/api/files/local/") and name in server.files:
                    data = server.files[name]
                    self.say(200, {"name": name, "size": len(data), "hash": hashlib.sha1(data).hexdigest()})
                else:
                    self.say(404, {"error": "not found"})

            def do_POST(self):
                path = self.known()
                body = self.rfile.read(int(self.headers["Content-Length"]))
                if path is None:
                    return
                if path != "/api/files/local":
                    server.started += 1
                    self.say(200, {})
                    return
                mark = re.search("boundary=(\\S+)", self.headers["Content-Type"])[1].strip('"').encode()
                part = next(part for part in body.split(b"--" + mark) if b'filename="' in part)
                head, _, data = part.partition(b"\r\n\r\n")
                name = re.search(b'filename="([^"]+)"', head)[1].decode()
                if len(body) == int(self.headers["Content-Length"]):
                    server.files[name] = data.removesuffix(b"\r\n")
                server.before()
                self.say(201, {"done": True, "files": {"local": {"name": name, "path": name}}})

        self.http = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Answers)
        self.address = f"octoprint:http://127.0.0.1:{self.http.server_address[1]}"

    def __enter__(self):
        self.thread = threading.Thread(target=self.http.serve_forever)
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.http.shutdown()
        self.http.server_close()
        self.thread.join()


class Published(Printed):
    def test_a_program_is_there_and_started(self):
        done = self.prepared()
        with Server() as server, Server() as other:
            first = trunnion.publish(done, to=server.address, name="first.gcode")
            second = trunnion.publish(done.output, self.folder / "small.json", to=server.address, start=True)
            self.assertEqual(server.files, {"first.gcode": done.gcode, "small.gcode": done.gcode})
            self.assertEqual((first.started, second.started, server.started), (False, True, 1))
            self.assertTrue(first.verified and first.uploads == 1 and first.sha256 == hashlib.sha256(done.gcode).hexdigest())
            self.assertEqual(first.stated.seconds_print, done.verify.seconds_print)
            self.assertEqual(pickle.loads(pickle.dumps(first)), first)
            # The command says the same of the same.
            code, document, said = command("publish", done.output, "--plan", self.folder / "small.json", "--to", other.address, "--start")
            self.assertEqual(code, 0, said)
            ours = json.loads(second.to_json().replace(server.address[10:], other.address[10:]))
            self.same(ours, document)
            # It is there already.
            self.assertEqual(trunnion.publish(done, to=server.address).uploads, 0)

    def test_a_key_is_repeated_nowhere(self):
        done, secret = self.prepared(), "KEY-OF-THE-TESTS"
        (self.folder / "key").write_text(secret + "\n")
        said = []
        with Server(key=secret) as server, self.assertLogs("trunnion", level="DEBUG") as heard, warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            for number, key in enumerate([{"key": secret}, {"key_file": self.folder / "key"}]):
                found = trunnion.publish(done, to=server.address, name=f"n{number}.gcode", progress=lambda one: said.append(repr(one)), **key)
                said += [repr(found), found.to_json()]
            # In the environment as the command has it.
            os.environ["TRUNNION_KEY"] = secret
            self.addCleanup(os.environ.pop, "TRUNNION_KEY")
            said.append(repr(trunnion.publish(done, to=server.address, name="n2.gcode")))
            self.assertEqual(sorted(server.files), ["n0.gcode", "n1.gcode", "n2.gcode"])
            for key, error in [
                ({"key": secret + "-NOT"}, trunnion.PrinterError), ({"key": secret + "\nX"}, trunnion.InputError),
                ({"key": [secret]}, trunnion.InputError), ({"key": secret, "key_file": self.folder / "key"}, trunnion.InputError),
                ({"key": secret, "fingerprint": "AB"}, trunnion.InputError), ({"key": secret, "timeout_s": 0}, trunnion.InputError),
                ({"key": secret, "name": "a b"}, trunnion.InputError),
            ]:  # fmt: skip
                with self.subTest(error=error), self.assertRaises(error) as caught:
                    trunnion.publish(done, to=server.address, **key)
                self.assertTrue(caught.exception.code)
                # A trace has lines of source, which are the caller's own.
                said += [str(caught.exception), json.dumps(caught.exception.to_dict()), repr(caught.exception)]
            said += traceback.format_exception_only(caught.exception)
        said += [record.getMessage() for record in heard.records] + [str(one.message) for one in warned]
        self.assertEqual([text for text in said if "OF-THE-TESTS" in text], [])

    def test_addresses_and_servers_that_cannot_be(self):
        done = self.prepared()
        with Server() as gone:
            nobody = gone.address
        for to in ["http://127.0.0.1", "octoprint:ftp://x", "octoprint:http://me:word@127.0.0.1", "moonraker:http://127.0.0.1:1", nobody]:
            code, document, _ = command("publish", done.output, "--plan", self.folder / "small.json", "--to", to)
            with self.subTest(to=to), self.assertRaises(trunnion.TrunnionError) as caught:
                trunnion.publish(done, to=to)
            error = caught.exception
            self.assertEqual((error.exit, error.code), (code, document["code"]))
            self.assertIsInstance(error, trunnion.PrinterError if code == 4 else trunnion.InputError)

    def test_an_unverified_program_is_published_where_that_is_said(self):
        path = self.program(moves(30))
        with Server() as server, self.assertWarns(trunnion.TrunnionWarning):
            found = trunnion.publish(path, to=server.address, unverified=True)
            self.assertEqual((found.verified, found.stated.seconds_print, server.files), (False, None, {"part.gcode": path.read_bytes()}))

    def test_what_is_called_off_during_the_upload_is_not_started(self):
        """Ctrl-C comes when the file is there and the server has not answered yet: the next request would be the start."""
        done, answer = self.prepared(), threading.Event()

        def before():
            os.kill(os.getpid(), signal.SIGINT)
            answer.wait(PATIENCE_S)

        with Server(before=before) as server:
            with self.assertRaises(KeyboardInterrupt):
                trunnion.publish(done, to=server.address, start=True)
            answer.set()
            # Whatever was left to end by itself asks nothing later.
            time.sleep(1.0)
            self.assertEqual(server.started, 0)
            self.assertEqual(server.asked[-1], ("POST", "/api/files/local"))

    def test_a_callback_that_raises_ends_the_upload(self):
        done = self.prepared()

        def progress(one):
            if one.text == "uploading":
                raise ZeroDivisionError

        with Server() as server:
            with self.assertRaises(ZeroDivisionError):
                trunnion.publish(done, to=server.address, start=True, progress=progress)
            time.sleep(0.5)
            self.assertEqual((server.files, server.started), ({}, 0))


if __name__ == "__main__":
    logging.getLogger("trunnion").setLevel(logging.DEBUG)
    unittest.main()
