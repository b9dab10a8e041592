"""Headless Chromium, driven through its own pipe by the DevTools protocol: pages, real mouse and keys, screenshots."""

import base64
import io
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np

SECONDS = 60  # longer than anything takes here
OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--remote-debugging-pipe",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--force-device-scale-factor=1",
)


def chromium():
    """The path of Chromium, or None."""
    return next(
        (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
    )


class Browser:
    """One page in a browser of its own, `size` pixels wide and high; `with` ends it."""

    def __init__(self, folder, size=(480, 360)):
        self.size, self._number, self._rest, self.events = size, 0, b"", []
        to_browser, self._to = os.pipe()
        self._from, from_browser = os.pipe()

        def in_place():  # the browser reads commands from file 3, and answers in file 4
            high = os.dup(from_browser), os.dup(to_browser)
            for source, place in ((high[1], 3), (high[0], 4)):
                os.dup2(source, place)

        width, height = size
        command = [chromium(), *OPTIONS, f"--user-data-dir={folder}", f"--window-size={width},{height}", "about:blank"]
        with open(Path(folder) / "said.txt", "wb") as said:
            self._process = subprocess.Popen(
                command, preexec_fn=in_place, close_fds=False, stdin=subprocess.DEVNULL, stdout=said, stderr=said
            )
        os.close(to_browser)
        os.close(from_browser)
        self._session = None
        page = next(t for t in self.ask("Target.getTargets")["targetInfos"] if t["type"] == "page")
        self._session = self.ask("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        self.ask("Page.enable")
        # Pages draw less where drawing takes long: with a clock that stands still it never does.
        self.ask("Page.addScriptToEvaluateOnNewDocument", source="performance.now = () => 0")
        self.ask("Runtime.enable")
        self.ask("Network.enable")
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        os.close(self._to)
        os.close(self._from)

    def ask(self, method, **parameters):
        """The result of one command."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + SECONDS
        while True:
            answer = self._next(until)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def _next(self, until):
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._from], [], [], max(0.0, until - time.monotonic()))
            read = os.read(self._from, 1 << 20) if ready else b""
            if not read:
                raise RuntimeError("the browser has ended" if ready else "the browser does not answer")
            self._rest += read
        line, _, self._rest = self._rest.partition(b"\0")
        return json.loads(line)

    def open(self, path, hash=""):
        """Loads a file and waits until its picture is done."""
        self.ask("Page.navigate", url="about:blank")  # from the same file with another hash it would only go there
        self.wait('location.href === "about:blank"')
        self.ask("Page.navigate", url=Path(path).resolve().as_uri() + hash)
        self.wait('document.body?.dataset.still || document.getElementById("fault")?.textContent')

    def visit(self, path):
        """Loads a file that is no page of surflux, with all that it loads."""
        address = Path(path).resolve().as_uri()
        self.ask("Page.navigate", url=address)
        self.wait(f'location.href === {json.dumps(address)} && document.readyState === "complete"')

    def run(self, script):
        """The value of an expression on the page."""
        found = self.ask("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            raise RuntimeError(found["exceptionDetails"])
        return found["result"].get("value")

    def wait(self, condition):
        until = time.monotonic() + SECONDS
        while not self.run(f"Boolean({condition})"):
            if self.complaints():
                raise RuntimeError(f"the page complains: {self.complaints()}")
            if time.monotonic() > until:
                raise RuntimeError(f"the page does not come to: {condition}")
            time.sleep(0.02)

    def wait_until(self, holds):
        """Asks again and again."""
        until = time.monotonic() + SECONDS
        while not holds():
            if time.monotonic() > until:
                raise RuntimeError("the page does not come to what is waited for")
            time.sleep(0.05)

    def settled(self, what):
        """Does something that makes the page draw anew, and waits until it stands still."""
        self.run("document.body.dataset.still = ''")
        what()
        self.wait("document.body.dataset.still")

    def mouse(self, kind, x, y, **more):
        self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, start, end, button="left", modifiers=0):
        """A real drag of the mouse, in ten steps."""
        held = {"button": button, "buttons": {"left": 1, "right": 2}[button], "modifiers": modifiers}
        self.mouse("mousePressed", *start, clickCount=1, **held)
        for k in range(1, 11):
            self.mouse("mouseMoved", *(a + k / 10 * (b - a) for a, b in zip(start, end, strict=True)), **held)
        self.mouse("mouseReleased", *end, clickCount=1, **(held | {"buttons": 0}))

    def click(self, x, y):
        for kind, buttons in (("mousePressed", 1), ("mouseReleased", 0)):
            self.mouse(kind, x, y, button="left", buttons=buttons, clickCount=1)

    def key(self, text):
        for kind in ("keyDown", "keyUp"):
            self.ask("Input.dispatchKeyEvent", type=kind, key=text, text=text if kind == "keyDown" else "")

    def picture(self, path=None):
        """(h, w, 3) integers: what the window shows."""
        from PIL import Image

        data = base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"])
        if path is not None:
            Path(path).write_bytes(data)
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)

    def requests(self):
        """Addresses that the page has asked for."""
        return [e["params"]["request"]["url"] for e in self.events if e.get("method") == "Network.requestWillBeSent"]

    def complaints(self):
        """Errors and exceptions of the page."""
        said = [e["params"] for e in self.events if e.get("method") in ("Runtime.exceptionThrown", "Log.entryAdded")]
        called = [e["params"] for e in self.events if e.get("method") == "Runtime.consoleAPICalled"]
        return said + [c for c in called if c["type"] in ("error", "warning")]
