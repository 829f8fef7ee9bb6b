"""``planner view`` and ``planner plan --view``: pages that the browser opens, and the live page until Ctrl-C."""

import http.client
import signal
import webbrowser
from pathlib import Path

import pytest

from tests.command_line import Run, command

STATE = ("--robot", "planar_2r", "--scene", "empty")
TASK = (*STATE, "--start", "q:0,1", "--goal", "q:1,1", "--nodes", "20")
PATIENCE = 60.0  # s, on a busy machine


@pytest.fixture(autouse=True)
def opened(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The addresses that a browser was asked to open."""
    addresses: list[str] = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("BROWSER", "true")  # of a command in a process of its own
    monkeypatch.setattr(webbrowser, "open", lambda address: addresses.append(address) or True)
    return addresses


@pytest.fixture
def folder(run: Run, tmp_path: Path) -> Path:
    """A plan with its page."""
    code, _, err = run("plan", *TASK, "--out", str(tmp_path / "a plan"))
    assert code == 0, err
    return tmp_path / "a plan"


def test_the_page_of_a_result_is_opened_from_disk(run: Run, folder: Path, opened: list[str]) -> None:
    for result in (folder, folder / "plan.json", folder / "plan.html"):
        assert run("view", str(result))[0] == 0
    assert opened == [(folder / "plan.html").as_uri()] * 3
    assert run("plan", *TASK, "--out", str(folder), "--view")[0] == 0
    assert opened[3:] == [(folder / "plan.html").as_uri()]


# states without a plan


@pytest.fixture
def post(tmp_path: Path) -> tuple[str, ...]:
    """planar_2r before a post that its stretched arm touches, with some named states."""
    path = tmp_path / "post.yaml"
    path.write_text(
        "obstacles:\n  - {name: post, type: box, size: [0.1, 0.1, 0.4], position: [0.8, 0, 0]}\n"
        "states:\n  planar_2r: {start: 'xyz:0.3,0.4,0', bad: 'q:0,3.5', goal: start}\n"
    )
    return ("--robot", "planar_2r", "--scene", str(path))


# the live page


@pytest.mark.parametrize("number", [signal.SIGTERM])
def test_a_live_page_is_served_until_a_signal(folder: Path, number: int) -> None:
    """Of a robot and a scene, or of a plan, with its start, goal and roadmap."""
    for words in ((*TASK, "--live"), (str(folder), "--live")):
        process = command("view", *words, cwd=folder)
        try:
            assert process.stdout is not None
            line = next(line for line in process.stdout if line.startswith("Serving http://127.0.0.1:"))
            connection = http.client.HTTPConnection(line.split("http://")[1].split("/")[0], timeout=PATIENCE)
            connection.request("GET", "/")
            assert connection.getresponse().status == 200
            connection.close()
            process.send_signal(number)
            _, err = process.communicate(timeout=PATIENCE)
            assert (process.returncode, err) == (0, "")
        finally:
            process.kill()
    assert not list(folder.glob("*.yaml"))
