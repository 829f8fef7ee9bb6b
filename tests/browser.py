"""Headless Chromium for the tests: a page's DOM after it has run, its console, its requests, its picture."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

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
    "--window-size=1200,800",
    "--virtual-time-budget=15000",
    "--enable-logging=stderr",
)
_CHROMIUMS_OWN = r"https?://[a-z0-9.-]*\.(google|googleapis|gvt1)\.com/"  # asked for on any page


@dataclass(frozen=True)
class Visit:
    """What a visit to a page showed."""

    dom: str
    console: list[str]
    requests: list[str]

    @property
    def ready(self) -> bool:
        head = self.dom[: self.dom.index("<head>")]
        return 'data-ready="true"' in head and "data-error" not in head


def require_browser() -> str:
    """The browser; without one the test is skipped, but in CI it fails."""
    if CHROMIUM is None:
        if os.environ.get("CI") == "true":
            pytest.fail("CI has no Chromium: .ci/run must install it")
        pytest.skip("no Chromium on this machine: install it to test the page")
    return CHROMIUM


def visit(page: Path) -> Visit:
    """Open a file in a fresh profile and wait until it has run."""
    with tempfile.TemporaryDirectory() as profile:
        log = Path(profile) / "net.json"
        done = _run(page, profile, "--dump-dom", f"--log-net-log={log}")
        urls = set(re.findall(r'"url":"((?:https?|wss?)://[^"]*)"', log.read_text()))
        requests = sorted(url for url in urls if not re.match(_CHROMIUMS_OWN, url))
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line and "GL Driver Message" not in line]
    return Visit(done.stdout, console, requests)


def screenshot(page: Path, picture: Path) -> None:
    """Write a PNG of the page."""
    with tempfile.TemporaryDirectory() as profile:
        _run(page, profile, f"--screenshot={picture}")


def _run(page: Path, profile: str, *flags: str) -> subprocess.CompletedProcess[str]:
    command = [require_browser(), *_FLAGS, f"--user-data-dir={profile}", *flags, page.resolve().as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)


def page_data(page: Path) -> dict:
    """The data that our script reads, out of the page's text."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read_text(), re.DOTALL)
    assert found
    return json.loads(found.group(1).replace("<\\/", "</"))
