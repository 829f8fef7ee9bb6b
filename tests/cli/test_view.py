"""``planner view`` and ``planner plan --view``: served to this machine alone, gone without a trace."""

from __future__ import annotations

import http.client
import json
import os
import shutil
import signal
import socket
import struct
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError
from planner.collision import make_checker
from planner.collision.clearance import Clearance
from planner.kinematics.forward import tool_positions
from planner.models.scene import Scene
from planner.view.serve import read_page
from tests.browser import page_data
from tests.command_line import Run, assert_refused, command
from tests.worlds import load

STATE = ("--robot", "planar_2r", "--scene", "empty")
TASK = (*STATE, "--start", "q:0,1", "--goal", "q:1,1", "--nodes", "20")
PATIENCE = 60.0  # s, on a busy machine


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a page that ``view`` can serve."""
    out = tmp_path_factory.mktemp("result")
    process = command("view", *STATE, "--out", "plan.html", cwd=out)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    (out / "plan.json").write_text("{}")
    return out


@contextmanager
def serving(*arguments: str, cwd: Path) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A serving command and its port; killed at the end if it has not gone by itself."""
    process = command(*arguments, cwd=cwd)
    assert process.stdout is not None
    try:
        for line in process.stdout:
            if "http://127.0.0.1:" in line:
                yield process, int(line.split("http://127.0.0.1:")[1].split("/")[0])
                return
        raise AssertionError(process.communicate()[1])
    finally:
        process.kill()
        process.communicate()


def get(port: int, path: str = "/", method: str = "GET", host: str | None = None) -> tuple[int, bytes, dict[str, str]]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    try:
        connection.request(method, path, headers={} if host is None else {"Host": host})
        answer = connection.getresponse()
        return answer.status, answer.read(), dict(answer.getheaders())
    finally:
        connection.close()


def listening(port: int, address: str = "127.0.0.1") -> bool:
    with socket.socket() as probe:
        probe.settimeout(2.0)
        return probe.connect_ex((address, port)) == 0


def other_addresses() -> list[str]:
    """Addresses of this machine that other machines see."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # a datagram socket sends nothing by connecting
        except OSError:
            return []
        return [probe.getsockname()[0]]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_serves_and_ends_cleanly(folder: Path, number: int) -> None:
    with serving("view", "plan.json", cwd=folder) as (process, port):
        status, body, headers = get(port)
        assert status == 200
        assert body == (folder / "plan.html").read_bytes()
        assert headers["Cache-Control"] == "no-store"
        assert get(port, method="HEAD")[1] == b""
        assert get(port, "/plan.json")[0] == 404
        assert get(port, "/../plan.json")[0] == 404
        assert get(port, host="evil.example")[0] == 403
        assert get(port, host=f"evil.example:{port}")[0] == 403
        assert get(port, host=f"localhost:{port}")[0] == 200
        assert not any(listening(port, address) for address in other_addresses())
        waiting = socket.create_connection(("127.0.0.1", port))  # one that never says a word holds nothing up
        process.send_signal(number)
        _, err = process.communicate(timeout=PATIENCE)
        waiting.close()
        assert process.returncode == 0
        assert err == ""
        assert not listening(port)
        with socket.socket() as again:
            again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            again.bind(("127.0.0.1", port))


def test_who_hangs_up_is_no_news(folder: Path) -> None:
    """Before asking, in the middle of a question and of the answer, politely (FIN) and not (RST)."""
    reset = struct.pack("ii", 1, 0)
    with serving("view", "plan.json", cwd=folder) as (process, port):
        question = f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode()
        for words in (b"", question[:9], question, question + question[:20]):
            for rude in (False, True):
                with socket.create_connection(("127.0.0.1", port)) as client:
                    if rude:
                        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, reset)
                    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                    client.sendall(words)
        assert get(port)[0] == 200
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE)
        assert (process.returncode, err) == (0, "")


def test_a_reload_shows_what_was_written_meanwhile(folder: Path, tmp_path: Path) -> None:
    page = tmp_path / "sweep.html"
    page.write_bytes((folder / "plan.html").read_bytes())
    with serving("view", str(tmp_path), "--port", "0", cwd=tmp_path) as (process, port):
        assert get(port)[0] == 200
        page.write_text(page.read_text().replace("<title>", "<title>new "))
        assert b"<title>new planar_2r" in get(port)[1]
        page.unlink()
        status, body, _ = get(port)
        assert status == 404
        assert b"not found" in body
        code, _, err = _finished(command("view", str(folder), "--port", str(port), cwd=tmp_path))
        assert code == 3
        assert f"port {port} cannot be used" in err
        code, out, err = _finished(command("view", "--live", "--port", str(port), cwd=tmp_path))
        assert (code, out) == (3, "")  # before anything is planned
        assert f"port {port} cannot be used" in err
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        if children.exists():
            assert children.read_text() == "", "no process of its own that could be left behind"


def test_a_page_of_another_run_than_its_record_is_noticed(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "plan.html", tmp_path)
    (tmp_path / "plan.json").write_text(json.dumps({"files": {"plan.html": "0" * 64}}))
    with serving("view", str(tmp_path), cwd=tmp_path) as (process, port):
        assert get(port)[0] == 200
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE)
    assert "plan.json was written with another plan.html than stands beside it: " in err


def test_plan_view_serves_the_plan(tmp_path: Path) -> None:
    with serving("plan", *TASK, "--out", "o", "--view", cwd=tmp_path) as (process, port):
        assert get(port)[1] == (tmp_path / "o" / "plan.html").read_bytes()
        process.send_signal(signal.SIGTERM)
        assert _finished(process)[0] == 0


def test_plan_json_prints_the_record_and_nothing_else(tmp_path: Path) -> None:
    code, out, err = _finished(command("plan", *TASK, "--json", cwd=tmp_path))
    assert code == 0, err
    assert out == (tmp_path / "out" / "plan.json").read_text()
    assert json.loads(out)["outcome"] == "solved"
    assert "Written:" in err


def _finished(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    out, err = process.communicate(timeout=PATIENCE)
    return process.returncode, out, err


# states without a plan


def seen(run: Run, folder: Path, *arguments: str) -> tuple[str, dict]:
    """What ``view --out`` says, and the data of the page it wrote."""
    page = folder / "deep" / "state.html"
    code, out, err = run("view", *arguments, "--out", str(page))
    assert code == 0, err
    assert f"Written: {page}" in out
    return out, page_data(page)


@pytest.fixture
def post(tmp_path: Path) -> tuple[str, ...]:
    """planar_2r before a post that its stretched arm touches, with some named states."""
    path = tmp_path / "post.yaml"
    path.write_text(
        "obstacles:\n  - {name: post, type: box, size: [0.1, 0.1, 0.4], position: [0.8, 0, 0]}\n"
        "states:\n  planar_2r: {start: 'xyz:0.3,0.4,0', bad: 'q:0,3.5', goal: start}\n"
    )
    return ("--robot", "planar_2r", "--scene", str(path))


def test_states_of_every_form(run: Run, tmp_path: Path, post: tuple[str, ...]) -> None:
    def place(*arguments: str) -> list[float]:
        data = seen(run, tmp_path, *post, *arguments)[1]
        return tool_positions(load("planar_2r"), np.array(data["paths"][0]["waypoints"]))[0].tolist()

    assert place() == pytest.approx([0.3, 0.4, 0.0], abs=1e-5)
    assert place("--state", "start") == place()
    assert place("--state", "xyz:-0.3,0.4,0") == pytest.approx([-0.3, 0.4, 0.0], abs=1e-5)
    assert place("--state", "pose:0.3,0.4,0,0,0,0,1", "--tool", "link_2") != place()
    home = tool_positions(load("planar_2r"), load("planar_2r").home)[0]
    assert place("--state", "home") == pytest.approx(home.tolist(), abs=1e-5)


def test_the_robots_home_where_the_scene_names_no_start(run: Run, tmp_path: Path) -> None:
    (tmp_path / "nothing.yaml").write_text("obstacles: []\n")
    data = seen(run, tmp_path, "--robot", "planar_2r", "--scene", str(tmp_path / "nothing.yaml"))[1]
    assert data["paths"][0]["waypoints"][0] == pytest.approx(load("planar_2r").home)


def test_a_state_in_collision_and_out_of_limits(run: Run, tmp_path: Path, post: tuple[str, ...]) -> None:
    words, data = seen(run, tmp_path, *post, "--state", "q:0,0")
    assert "'link_2' and 'post' touch" in words
    assert set(data["touching"]) >= {"link_2", "post"}
    assert "contact" in data["wrong"]
    words, data = seen(run, tmp_path, *post, "--state", "bad")
    assert "out of limits: joint_2" in words
    assert "joint_2" in data["wrong"]
    words, data = seen(run, tmp_path, *post, "--state", "q:0.9,0", "--margin", "0.6")
    assert "are closer than the margin of 0.6 m" in words


def test_a_clearance_that_rounds_to_nothing_says_what_it_means(run: Run, tmp_path: Path) -> None:
    """A post 0.03 mm beyond the stretched arm: free by the library, and closer than any proof can tell."""
    path = tmp_path / "near.yaml"
    tip = float(tool_positions(load("planar_2r"), np.zeros(2))[0, 0])
    box = "obstacles:\n  - {{name: post, type: box, size: [0.1, 0.1, 0.4], position: [{x!r}, 0, 0]}}\n"
    low, high = tip, tip + 0.2  # where the arm's rounded end stops is asked of the planner itself
    for _ in range(40):
        middle = 0.5 * (low + high)
        path.write_text(box.format(x=middle))
        clearance = Clearance(make_checker(load("planar_2r"), Scene.load(str(path))))(np.zeros(2))[0]
        low, high = (middle, high) if clearance < 3e-5 else (low, middle)
    path.write_text(box.format(x=high))
    words, data = seen(run, tmp_path, "--robot", "planar_2r", "--scene", str(path), "--state", "q:0,0")
    assert "Free and within limits" not in words
    assert "the clearance is less than 0.1 mm, which no proof can tell from contact" in words
    assert "less than 0.1 mm" in dict(data["paths"][0]["numbers"])["clearance"]
    path.write_text(box.format(x=high + 0.001))
    words, data = seen(run, tmp_path, "--robot", "planar_2r", "--scene", str(path), "--state", "q:0,0")
    assert "Free and within limits." in words
    assert dict(data["paths"][0]["numbers"])["clearance"] == "1.0 mm"


def test_a_target_that_only_collisions_reach(run: Run, tmp_path: Path, post: tuple[str, ...]) -> None:
    words, data = seen(run, tmp_path, *post, "--state", "xyz:0.8,0,0")
    assert "'post' touch" in words
    assert dict(data["paths"][0]["numbers"])["tool (m)"] == "0.800, 0.000, 0.000"


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (("--state", "nowhere"), 3, "'nowhere' is not among the scene's states"),
        (("--state", "start,goal"), 3, "names 2 states"),
        (("--state", "q:1,2"), 3, "2 joint values, iiwa14 has 7"),
        (("--state", "q:nan,0,0,0,0,0,0"), 3, "not finite"),
        (("--state", "xyz:3,0,0"), 3, "beyond the arm's reach"),
        (("--state", "q:one"), 2, "no number"),
        (("--robot", "r2d2"), 3, "robot 'r2d2' not found"),
        (("--port", "70000"), 2, "port 70000"),
    ],
)
def test_wrong_states(run: Run, tmp_path: Path, arguments: tuple[str, ...], code: int, text: str) -> None:
    out = tmp_path / "out"
    assert_refused(run("view", *arguments, "--out", str(out / "state.html")), code, text, out)


def test_a_place_that_cannot_be_written_is_refused_first(run: Run, tmp_path: Path) -> None:
    code, out, err = run("view", "--out", str(tmp_path))
    assert (code, out) == (3, "")
    assert "is a folder: give the name of a file" in err


def test_wrong_results(run: Run, folder: Path, tmp_path: Path) -> None:
    def refused(code: int, text: str, *arguments: str) -> None:
        assert_refused(run("view", *arguments), code, text, tmp_path / "none")

    refused(3, "holds neither plan.html nor sweep.html", str(tmp_path))
    refused(3, "none.html not found", str(tmp_path / "none.json"))
    (tmp_path / "plan.html").write_text("<html></html>")
    refused(3, "is not a whole page of this planner", str(tmp_path))
    (tmp_path / "sweep.html").write_text("<html></html>")
    refused(3, "holds plan.html and sweep.html: name one", str(tmp_path))
    refused(2, "give RESULT or options for a state, not both", str(folder), "--state", "home")
    refused(2, "not both", str(folder), "--robot", "panda")
    refused(2, "not both", str(folder), "--out", "x.html")


def test_half_a_page_is_no_page(folder: Path, tmp_path: Path) -> None:
    whole = (folder / "plan.html").read_bytes()
    (tmp_path / "plan.html").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(FileError, match="not a whole page"):
        read_page(tmp_path / "plan.html")
    assert read_page(folder / "plan.html") == whole


def test_open_says_so_where_there_is_no_screen(folder: Path) -> None:
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    process = command("view", "plan.html", "--open", cwd=folder, env=environment)
    assert process.stdout is not None
    begun = time.monotonic()
    lines = [process.stdout.readline(), process.stdout.readline()]
    assert time.monotonic() - begun < PATIENCE
    assert "Serving http://127.0.0.1:" in lines[0]
    assert "open the address yourself" in lines[1]
    process.send_signal(signal.SIGINT)
    assert _finished(process)[0] == 0


# the live page


def test_a_live_page_is_served_and_ends_cleanly(tmp_path: Path) -> None:
    task = (*STATE, "--start", "q:0,1", "--goal", "q:1,1", "--nodes", "20")
    with serving("view", "--live", *task, cwd=tmp_path) as (process, port):
        assert get(port)[0] == 403
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE)
        assert (process.returncode, err) == (0, "")
    assert list(tmp_path.iterdir()) == []


LIVE_REFUSED = {
    "a result": (("view", "plan.json", "--live"), 2, "--live plans anew"),
    "a state": (("view", "--live", *STATE, "--state", "home"), 2, "--live plans anew"),
    "a question without it": (("view", *STATE, "--beta", "0.5"), 2, "are for --live"),  # the default, said
    "a page as its file": (("view", "--live", *STATE, "--out", "state.html"), 2, "ends in .yaml"),
    "a port for a file": (("view", *STATE, "--out", "state.html", "--port", "8000"), 2, "leave out --port and --open"),
    "beta": (("view", "--live", *STATE, "--beta", "2"), 2, "outside [0, 1]"),
    "a start beyond its limits": (
        ("view", "--live", *STATE, "--start", "q:0,9", "--goal", "q:1,1"),
        3,
        "outside its limits",
    ),
}


@pytest.mark.parametrize("case", LIVE_REFUSED)
def test_no_live_page(run: Run, tmp_path: Path, case: str) -> None:
    words, code, sentence = LIVE_REFUSED[case]
    assert_refused(run(*words), code, sentence, tmp_path / "empty-moved.yaml")
