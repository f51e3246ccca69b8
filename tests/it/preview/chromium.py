"""Opens a page in headless Chromium and does what it is told, through the browser's own debugging pipe: nothing to install.

Arguments: the browser, the page's file or address, width, height. Standard input: a JSON list of steps, each one of
  {"eval": JAVASCRIPT}       its value (awaited) is among the results
  {"shot": FILE.png}         a screenshot; what "first": JAVASCRIPT does comes before it (awaited)
  {"key": KEY}               pressed and released, as a person would; Control+z with a key held
  {"click": SELECTOR}        the middle of the element, with the mouse
  {"drag": [FROM, TO]}       the mouse goes down on one element and up on another; or between two places, JAVASCRIPT's value
  {"at": [X, Y]}             a place of the page, with the mouse
  {"frame": JAVASCRIPT}      its value in the page's frame, which is a site of its own
  {"until": JAVASCRIPT}      waits until it is true
  {"text": TEXT}             typed where the focus is
  {"files": [FILE..]}        chosen in the page's first input for files
  {"size": [X, Y]}           of the page; {"scheme": "dark"} or "light" is the system's
Standard output: {"results": [one a step], "console": [texts of errors and warnings], "requests": [addresses]}.
"""

import base64
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

FLAGS = [
    "--headless=new", "--remote-debugging-pipe", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--no-first-run", "--no-default-browser-check", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--hide-scrollbars", "--force-device-scale-factor=1", "--no-sandbox", "--disable-dev-shm-usage",
    "--disable-extensions", "--force-color-profile=srgb",
]
# For what hangs alone: on a busy machine a page has taken 253 s. The runner ends a test after 1,200.
SECONDS = 1000


class Browser:
    """The two ends of the pipe: messages are JSON, each with a zero byte behind it."""

    def __init__(self, program, profile, size):
        to_browser, self.write_end = os.pipe()
        self.read_end, from_browser = os.pipe()

        def ends():
            # In between on other numbers: one of the four may be 3 or 4 already.
            a, b = os.dup(to_browser), os.dup(from_browser)
            os.dup2(a, 3)
            os.dup2(b, 4)

        args = [program, *FLAGS, f"--user-data-dir={profile}", "--window-size=%d,%d" % size, "about:blank"]
        self.process = subprocess.Popen(
            args, preexec_fn=ends, close_fds=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        os.close(to_browser)
        os.close(from_browser)
        self.rest, self.count, self.session, self.frame = b"", 0, None, None
        self.console, self.requests = [], []

    def read(self):
        while b"\0" not in self.rest:
            more = os.read(self.read_end, 1 << 20)
            if not more:
                raise SystemExit("the browser has gone")
            self.rest += more
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def note(self, message):
        """Keeps what must not happen."""
        method, params = message.get("method"), message.get("params", {})
        if method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            self.console.append(" ".join(str(a.get("value", a.get("description"))) for a in params["args"]))
        elif method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.console.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            self.console.append(params["entry"]["text"])
        elif method == "Target.attachedToTarget":
            # A frame of a site of its own, whose words are heard too.
            if params["targetInfo"]["type"] == "iframe":
                self.frame = params["sessionId"]
            for domain in ("Runtime", "Log", "Network"):
                self.count += 1
                self.send({"id": self.count, "method": f"{domain}.enable", "sessionId": params["sessionId"]})
        elif method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"][:200])

    def send(self, message):
        os.write(self.write_end, json.dumps(message).encode() + b"\0")

    def ask(self, method, **params):
        self.count += 1
        number = self.count
        message = {"id": number, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        self.send(message)
        while True:
            answer = self.read()
            if answer.get("id") == number:
                if "error" in answer:
                    raise SystemExit(f"{method}: {answer['error']}")
                return answer["result"]
            self.note(answer)

    def value(self, code):
        answer = self.ask("Runtime.evaluate", expression=code, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            raise SystemExit(f"{code}: {details.get('exception', {}).get('description', details['text'])}")
        return answer["result"].get("value")

    def size(self, width, height):
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def press(self, x, y):
        for kind in ("mousePressed", "mouseReleased"):
            self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def middle(self, selector):
        return self.value(
            f"(() => {{ const e = document.querySelector({json.dumps(selector)}); e.scrollIntoView({{block: 'nearest'}});"
            " const b = e.getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]; })()"
        )

    def drag(self, places):
        (x, y), (to_x, to_y) = self.value(places) if isinstance(places, str) else map(self.middle, places)
        self.ask("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", clickCount=1)
        for step in range(1, 9):
            at = [x + (to_x - x) * step / 8, y + (to_y - y) * step / 8]
            self.ask("Input.dispatchMouseEvent", type="mouseMoved", x=at[0], y=at[1], button="left", buttons=1)
        self.ask("Input.dispatchMouseEvent", type="mouseReleased", x=to_x, y=to_y, button="left", clickCount=1)

    def key(self, key):
        *held, key = key.split("+") if len(key) > 1 else [key]
        flags = sum({"Alt": 1, "Control": 2, "Meta": 4, "Shift": 8}[name] for name in held)
        if flags:
            for kind in ("rawKeyDown", "keyUp"):
                self.ask("Input.dispatchKeyEvent", type=kind, key=key, modifiers=flags, windowsVirtualKeyCode=ord(key[0].upper()))
            return
        text = key if len(key) == 1 else "\r" if key == "Enter" else ""
        # Without its number a key moves no focus.
        number = {"Tab": 9, "Enter": 13}.get(key, 0)
        self.ask("Input.dispatchKeyEvent", type="keyDown", key=key, text=text, windowsVirtualKeyCode=number)
        self.ask("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=number)


def main():
    program, page, width, height = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    page = page if page.startswith("http:") else pathlib.Path(page).resolve().as_uri()
    steps, results = json.load(sys.stdin), []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile, (width, height))
        watch = threading.Timer(SECONDS, browser.process.kill)
        watch.start()
        try:
            pages = [t for t in browser.ask("Target.getTargets")["targetInfos"] if t["type"] == "page"]
            browser.session = browser.ask("Target.attachToTarget", targetId=pages[0]["targetId"], flatten=True)["sessionId"]
            for domain in ("Runtime", "Log", "Network", "Page"):
                browser.ask(f"{domain}.enable")
            browser.ask("Target.setAutoAttach", autoAttach=True, waitForDebuggerOnStart=False, flatten=True)
            browser.size(width, height)
            browser.ask("Page.navigate", url=page)
            while not browser.value("location.protocol !== 'about:' && document.readyState === 'complete'"):
                time.sleep(0.02)
            for step in steps:
                results.append(do(browser, step))
        finally:
            watch.cancel()
            browser.process.kill()
            browser.process.wait()
    json.dump({"results": results, "console": browser.console, "requests": browser.requests}, sys.stdout)


def do(browser, step):
    if "eval" in step:
        return browser.value(step["eval"])
    if "shot" in step:
        browser.value(step.get("first", "0"))
        picture = base64.b64decode(browser.ask("Page.captureScreenshot", format="png")["data"])
        pathlib.Path(step["shot"]).write_bytes(picture)
    elif "key" in step:
        browser.key(step["key"])
    elif "click" in step:
        box = browser.middle(step["click"])
        browser.press(*box)
    elif "drag" in step:
        browser.drag(step["drag"])
    elif "at" in step:
        browser.press(*step["at"])
    elif "until" in step:
        while not browser.value(f"(() => {{ try {{ return Boolean({step['until']}); }} catch {{ return false; }} }})()"):
            time.sleep(0.02)
    elif "frame" in step:
        page = browser.session
        while not browser.frame:
            browser.value("0")
        browser.session = browser.frame
        while browser.value("document.readyState") != "complete":
            time.sleep(0.02)
        value = browser.value(step["frame"])
        browser.session = page
        return value
    elif "text" in step:
        browser.ask("Input.insertText", text=step["text"])
    elif "files" in step:
        root = browser.ask("DOM.getDocument")["root"]["nodeId"]
        node = browser.ask("DOM.querySelector", nodeId=root, selector="input[type=file]")["nodeId"]
        browser.ask("DOM.setFileInputFiles", files=step["files"], nodeId=node)
    elif "size" in step:
        browser.size(*step["size"])
    elif "scheme" in step:
        browser.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": step["scheme"]}])
    return None


main()
