"""Headless Chromium for the tests, driven through its DevTools."""

import asyncio
import base64
import contextlib
import gzip
import io
import json
import os
import re
import shutil
import subprocess
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from tornado.websocket import WebSocketClientConnection, websocket_connect

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
PATIENCE = 60.0  # s that a page may take on a busy machine; a ready one is not waited for

_FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--window-size=1000,760",
    "--remote-debugging-port=0",
)


def require_browser() -> str:
    """The browser; without one the test is skipped, but in CI it fails."""
    if CHROMIUM is None:
        if os.environ.get("CI") == "true":
            pytest.fail("CI has no Chromium: .ci/run must install it")
        pytest.skip("no Chromium on this machine: install it to test the page")
    return CHROMIUM


class Tab:
    """One page in one fresh browser: evaluates scripts, takes pictures, keeps the console and the requests."""

    def __init__(self, socket: WebSocketClientConnection, loop: asyncio.AbstractEventLoop) -> None:
        self._socket, self._loop, self._number = socket, loop, 0
        self.console: list[str] = []
        self.requests: list[str] = []

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a DevTools command, wait for its answer and note the events until then."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        return self._loop.run_until_complete(asyncio.wait_for(self._exchange(message), PATIENCE))

    async def _exchange(self, message: dict[str, Any]) -> dict[str, Any]:
        await self._socket.write_message(json.dumps(message))
        while True:
            text = await self._socket.read_message()
            assert text is not None, "Chromium has gone"
            answer = json.loads(text)
            if answer.get("id") == message["id"]:
                assert "error" not in answer, answer
                return answer["result"]
            self._note(answer)

    def _note(self, event: dict[str, Any]) -> None:
        details = event.get("params", {})
        if event["method"] == "Network.requestWillBeSent":
            url = details["request"]["url"]
            if re.match(r"(https?|wss?|ftp):", url):
                self.requests.append(url)
        elif event["method"] == "Runtime.exceptionThrown":
            self.console.append(json.dumps(details["exceptionDetails"])[:500])
        elif event["method"] == "Log.entryAdded" and "GL Driver Message" not in details["entry"]["text"]:
            self.console.append(details["entry"]["text"])
        elif event["method"] == "Runtime.consoleAPICalled" and details["type"] in ("error", "warning"):
            self.console.append(json.dumps(details["args"])[:500])

    def run(self, script: str) -> Any:
        """The value of a JavaScript expression."""
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def open(self, page: Path | str) -> bool:
        """Go to a page (a file or an address), forget the notes of the last one; whether it gets ready."""
        self.run("void delete document.documentElement.dataset.ready")
        self.call("Page.navigate", url=page if isinstance(page, str) else page.resolve().as_uri())
        self.console.clear()
        self.requests.clear()
        return self.settled()

    def drawn(self) -> None:
        """Wait until the page has drawn the last change."""
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def press(self, key: str, code: str = "") -> None:
        """A key of the keyboard, down and up."""
        text = {"text": key} if len(key) == 1 else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, code=code or key, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, code=code or key)

    def mouse(self, x: float, y: float, click: bool = False) -> None:
        """The pointer at a place of the window (pixels), pressed and let go there if ``click``."""
        self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        for kind in ("mousePressed", "mouseReleased") if click else ():
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
        self.drawn()

    def click(self, selector: str) -> None:
        """Click in the middle of the element that ``selector`` finds, with the mouse."""
        script = f"document.querySelector({json.dumps(selector)})"
        self.run(f"{script}.scrollIntoView({{block: 'nearest'}})")
        box = self.run(
            f"(({{x, y, width, height}}) => [x + width / 2, y + height / 2])({script}.getBoundingClientRect())"
        )
        self.mouse(*box, click=True)

    def settled(self) -> bool:
        """Wait until the page says that it is ready (True) or that it failed (False)."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            # while it is being opened a page has no root for a moment
            state = self.run("(r => r?.error ? 'error' : r?.ready ?? '')(document.documentElement?.dataset)")
            if state:
                return state == "true"
            time.sleep(0.1)
        return False

    def screenshot(self) -> np.ndarray:
        """The visible picture, (height, width, 3) from 0 to 255."""
        png = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)


@contextlib.contextmanager
def browser() -> Iterator[Tab]:
    """A fresh browser with an empty page, gone when the block ends."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [require_browser(), *_FLAGS, f"--user-data-dir={profile}", "about:blank"]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        loop = asyncio.new_event_loop()
        try:
            address = _debugger(Path(profile), process)
            socket = loop.run_until_complete(_connect(address))
            tab = Tab(socket, loop)
            for domain in ("Page", "Network", "Runtime", "Log"):
                tab.call(f"{domain}.enable")
            yield tab
            socket.close()
        finally:
            process.kill()
            process.wait()
            loop.close()


async def _connect(address: str) -> WebSocketClientConnection:
    return await websocket_connect(address, max_message_size=1 << 28)


def _debugger(profile: Path, process: subprocess.Popen[bytes]) -> str:
    """The DevTools address of the first tab, once Chromium has written down its port."""
    port_file, end = profile / "DevToolsActivePort", time.monotonic() + PATIENCE
    while time.monotonic() < end:
        assert process.poll() is None, "Chromium ended at once"
        with contextlib.suppress(OSError, ValueError, IndexError, StopIteration):
            port = int(port_file.read_text().splitlines()[0])
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/json", timeout=10) as answer:
                return next(tab["webSocketDebuggerUrl"] for tab in json.load(answer) if tab["type"] == "page")
        time.sleep(0.1)
    raise AssertionError("Chromium did not open its DevTools")


def choose(tab: Tab, element: str, value: str) -> None:
    tab.run(f"(e => {{ e.value = {json.dumps(value)}; e.dispatchEvent(new Event('change')); }})(element('{element}'))")
    tab.drawn()


def drag(tab: Tab, element: str, value: float, let_go: bool = True) -> None:
    """A range dragged to a value."""
    for event in ("input", "change") if let_go else ("input",):
        tab.run(f"(e => {{ e.value = {value}; e.dispatchEvent(new Event('{event}')); }})(element('{element}'))")
    tab.drawn()


def dataset(tab: Tab, name: str) -> str:
    return tab.run(f"document.documentElement.dataset.{name}")


def text(tab: Tab, element: str) -> str:
    return tab.run(f"element('{element}').innerText")


def text_content(tab: Tab, element: str) -> str:
    """Its text letter by letter, folded or not."""
    return tab.run(f"element('{element}').textContent")


def page_data(page: Path) -> dict[str, Any]:
    """The data that our script reads, out of the page's text."""
    found = re.search(r'<script type="text/plain" id="data">(.*?)</script>', page.read_text(), re.DOTALL)
    assert found
    return json.loads(gzip.decompress(base64.b64decode(found.group(1))))
