"""Files that once ended in a foreign exception, a crash, a hang or raw text: each is refused with one sentence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import FileError, PlannerError, RobotError, SceneError
from planner.base.files import is_file, require_writable_file, require_writable_folder
from planner.base.silenced import Silenced
from planner.base.yamlfile import parse_yaml, shown
from planner.world.dae import dae_fault
from planner.world.meshes import read_mesh
from planner.world.ply import ply_fault
from planner.world.robot import Robot, load_visuals
from planner.world.scene import Scene
from tests.worlds import joint_xml, link_xml

BOX = "obstacles: [{name: a, type: box, size: [1, 1, 1], MORE}]"
MOVEIT = "world: {collision_objects: [OBJECT]}"
MESH = "{id: a, mesh_poses: [{}], meshes: [{vertices: VERTICES, triangles: [{vertex_indices: INDICES}]}]}"
CORNERS = "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]"

SCENES = {
    "a position of 1e20": (BOX.replace("MORE", "position: [1.0e+20, 0, 0]"), "position.0"),
    "a base of 1e300": ("robots: {iiwa14: {base: {position: [1.0e+300, 0, 0]}}}", "base.position.0"),
    "degrees": (BOX.replace("MORE", "rpy: [0, 90, 0]"), "degrees?"),
    "5000 digits": (BOX.replace("MORE", f"position: [{'9' * 5000}, 0, 0]"), "4300 digits"),
    "no digits": (BOX.replace("MORE", "position: [0b9, 0, 0]"), "got '0b9'"),
    "an empty whole number": (BOX.replace("MORE", "position: [!!int '', 0, 0]"), "cannot make sense"),
    "a month too many": ("name: 2001-13-45", "month must be in 1..12"),
    "half a surrogate pair": ('name: "\\ud800"', "invalid Unicode"),
    "a name of 300,000 letters": (f"name: {'a' * 300_000}", "at most 1000 characters"),
    "a capsule of 1e-9": ("obstacles: [{name: a, type: capsule, radius: 0.1, length: 1.0e-9}]", "capsule.length"),
    "a mesh of 300 letters": (f"obstacles: [{{name: a, type: mesh, file: {'x' * 300}}}]", "too long"),
    "a mesh with a zero byte": ('obstacles: [{name: a, type: mesh, file: "a\\0"}]', "null byte"),
    "vertices that are no list": (MOVEIT.replace("OBJECT", MESH.replace("VERTICES", "5")), "valid list"),
    "a huge index": (
        MOVEIT.replace("OBJECT", MESH.replace("VERTICES", CORNERS).replace("INDICES", f"[0, 1, {10**25}]")),
        "vertex_indices.2",
    ),
    "a quaternion of zero": (
        MOVEIT.replace("OBJECT", "{id: a, pose: {orientation: [0, 0, 0, 0]}, primitives: [], primitive_poses: []}"),
        "[0, 0, 0, 1] is no turn",
    ),
    "a matrix without enabled": (
        "world: {}\nallowed_collision_matrix: {entry_names: [a], entry_values: [{x: 1}]}",
        "list",
    ),
    "a row that is no list": ("world: {}\nallowed_collision_matrix: {entry_names: [a], entry_values: [1]}", "list"),
}


@pytest.mark.parametrize("name", SCENES)
def test_scenes(name: str, tmp_path: Path) -> None:
    text, part = SCENES[name]
    (tmp_path / "bad.yaml").write_text(text)
    assert part in _sentence(lambda: Scene.load(str(tmp_path / "bad.yaml")))


HEAD = "n\n* a\n1\nbox\n1 1 1\n0 0 0\n0 0 0 1\n0 0 0 0\n"


@pytest.mark.parametrize("end", ["9" * 5000, "999999999", "²"])
@pytest.mark.parametrize("count", ["1", "99999999999", "1.5", "-1"])
def test_scene_texts(count: str, end: str, tmp_path: Path) -> None:
    (tmp_path / "bad.scene").write_text(HEAD.replace("\n1\n", f"\n{count}\n", 1) + end + "\n.")
    assert "export it again" in _sentence(lambda: Scene.load(str(tmp_path / "bad.scene")))


A, B, C = (link_xml(name, '<sphere radius="0.1"/>') for name in "abc")
J = joint_xml("j", "a", "b")
ROBOTS = {
    "nested deeply": (A + B + J + "<x>" * 5000 + "</x>" * 5000, "nests elements"),
    "1001 links": ("".join(link_xml(f"l{k}") for k in range(1001)), "1001 links"),
    "201 joints": (
        "".join(link_xml(f"l{k}") for k in range(202))
        + "".join(joint_xml(f"j{k}", f"l{k}", f"l{k + 1}") for k in range(201)),
        "201 moving joints",
    ),
    "501 bodies": (link_xml("a").replace("></link>", ">" + "<collision/>" * 500 + "</link>") + B + J, "501 collision"),
    "a joint called universe": (A + B + joint_xml("universe", "a", "b"), "'universe'"),
    "a link called universe": (link_xml("universe") + B + joint_xml("j", "universe", "b"), "'universe'"),
    "two joints of one name": (A + B + C + J + joint_xml("j", "b", "c"), "two joints called 'j'"),
    "a loop": (A + B + J + joint_xml("k", "b", "a"), "loop"),
    "two parents": (A + B + C + J + joint_xml("k", "c", "b"), "child of two joints"),
    "an axis without direction": (A + B + joint_xml("j", "a", "b", axis="0 0 0"), "no direction"),
    "an origin of 1e300": (A + B + joint_xml("j", "a", "b", xyz="1e300 0 0"), "beyond 10000"),
    "an origin of nan": (A + B + joint_xml("j", "a", "b", xyz="nan 0 0"), "3 finite numbers"),
    "a cylinder of radius 0": (link_xml("a", '<cylinder radius="0" length="1"/>') + B + J, "no size"),
    "a capsule of length 0": (link_xml("a", '<capsule radius="1" length="0"/>') + B + J, "no size"),
    "a mesh scaled to nothing": (link_xml("a", '<mesh filename="x.stl" scale="0 0 0"/>') + B + J, "leaves nothing"),
    "a collision without geometry": (A + '<link name="b"><collision/></link>' + J, "1 of the 2 collision geometries"),
    "limits in degrees": (A + B + joint_xml("j", "a", "b", limit="-170 170"), "degrees?"),
    "limits of 1e308": (A + B + joint_xml("j", "a", "b", "prismatic", limit="-1e308 1e308"), "real ones"),
    "a joint of no known kind": (A + B + joint_xml("j", "a", "b", "wobbly"), "no known type [wobbly]"),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_robots(name: str, urdf_file: Callable[..., str], capfd: pytest.CaptureFixture[str]) -> None:
    """In our own words: urdfdom's do not reach standard error."""
    inside, part = ROBOTS[name]
    path = urdf_file(inside)
    assert part in _sentence(lambda: Robot.load(path))
    assert capfd.readouterr() == ("", "")


def _sentence(load: Callable[[], object]) -> str:
    with pytest.raises(PlannerError) as caught:
        load()
    text = str(caught.value)
    assert caught.value.exit_code == 3
    assert text.endswith(".")
    assert "\n" not in text
    assert len(text) < 1000
    return text


# joints that follow others

_MIMIC = '<mimic joint="finger" multiplier="-2" offset="0.1"/></joint>'
_OTHER = joint_xml("other", "b", "d", "prismatic").replace("</joint>", _MIMIC)
GRIPPER = A + B + C + link_xml("d", '<sphere radius="0.1"/>') + J + joint_xml("finger", "b", "c", "prismatic") + _OTHER


def test_a_held_joint_follows_the_one_it_mimics(urdf_file: Callable[..., str]) -> None:
    path = urdf_file(GRIPPER)
    held = Robot.load(path, tool="b", fixed_joints={"finger": 0.3})
    assert held.fixed_joints == pytest.approx({"finger": 0.3, "other": -0.5})
    (body,) = [body for body in held.bodies if body.link == "d"]
    assert body.placement[2, 3] == pytest.approx(-0.5)
    assert Robot.load(path, tool="b").fixed_joints == pytest.approx({"other": 0.1})
    assert Robot.load(path, tool="b", fixed_joints={"other": 0.2}).fixed_joints == {"other": 0.2}, "as it was asked"


def test_a_mimic_joint_that_would_have_to_move_is_refused(urdf_file: Callable[..., str]) -> None:
    path = urdf_file(GRIPPER)
    with pytest.raises(RobotError, match="'other' mimics 'finger', which is planned, and moves a collision body"):
        Robot.load(path, tool="c")
    with pytest.raises(RobotError, match="'other' mimics 'finger' and cannot be planned by itself"):
        Robot.load(path, tool="d")
    assert Robot.load(path, tool="c", fixed_joints={"other": 0.0}).joints == ("j", "finger")
    nowhere = urdf_file(GRIPPER.replace('mimic joint="finger"', 'mimic joint="nobody"'))
    with pytest.raises(RobotError, match="mimics 'nobody'"):
        Robot.load(nowhere, tool="b")
    itself = urdf_file(GRIPPER.replace('mimic joint="finger"', 'mimic joint="other"'))
    with pytest.raises(RobotError, match="mimics 'other'"):
        Robot.load(itself, tool="b")


def test_visuals_that_cannot_be_read_do_not_cost_the_plan(urdf_file: Callable[..., str]) -> None:
    visual = '<visual><geometry><mesh filename="gone.stl"/></geometry></visual></link>'
    robot = Robot.load(urdf_file(A.replace("</link>", visual) + B + J))
    assert load_visuals(robot) == robot.bodies


# meshes

PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
)


def test_a_sound_ply_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_text(PLY)
    assert len(read_mesh(tmp_path / "a.ply").triangles) == 1


@pytest.mark.parametrize(
    "bad",
    [
        PLY.replace("3 0 1 2", "3 0 1 99999999"),  # each of these crashed or filled the memory
        PLY.replace("3 0 1 2", "~ 0 1 2"),
        PLY.replace("3 0 1 2", "999999999 0 1 2"),
        PLY.replace("vertex 3", "vertex 999999999"),
        PLY.replace("1 0 0\n", ""),
        PLY.replace("property float y", "property float x"),
        PLY.replace("property float z", "property float z\nproperty float w"),
        PLY.replace("3 0 1 2", "3 0 1"),
        PLY.replace("element face 1", "element face true"),
        PLY.replace("ascii", "binary_little_endian"),
        PLY[:60],
    ],
)
def test_a_ply_that_does_not_fit_never_reaches_its_reader(bad: str, tmp_path: Path) -> None:
    assert ply_fault(PLY.encode()) is None
    assert ply_fault(bad.encode()) is not None
    (tmp_path / "a.ply").write_text(bad)
    assert "export it again" in _sentence(lambda: read_mesh(tmp_path / "a.ply"))


DAE = "<COLLADA><mesh><float_array count='3'>0 0 1</float_array><p>0 1 2</p></mesh></COLLADA>"


@pytest.mark.parametrize(
    "bad",
    [
        DAE.replace("<p>0", "<p>.nan"),  # Assimp allocates until there is nothing left
        DAE.replace("<p>0", "<p>-1"),
        DAE.replace("count='3'", "count='999999999'"),
        DAE.replace("0 0 1", "0 0 x"),
        DAE.replace("<mesh>", "<x>" * 300 + "</x>" * 300 + "<mesh>"),
        DAE[:30],
    ],
)
def test_a_dae_that_does_not_fit_never_reaches_its_reader(bad: str) -> None:
    assert dae_fault(DAE.encode()) is None
    assert dae_fault(bad.encode()) is not None


@pytest.mark.parametrize("corner", ["nan 0 0", "1e30 0 0", "inf 0 0"])
def test_vertices_out_of_range(corner: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    facet = f"facet normal 0 0 1\nouter loop\nvertex {corner}\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "a.stl").write_text(f"solid x\n{facet}{facet}endsolid x\n")
    _sentence(lambda: read_mesh(tmp_path / "a.stl"))
    assert capfd.readouterr() == ("", ""), "the libraries' own text"


# places on the disk


@pytest.fixture
def loop(tmp_path: Path) -> Path:
    """Two links that name each other."""
    (tmp_path / "a").symlink_to(tmp_path / "b")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    return tmp_path / "a"


def test_places_that_cannot_be_written_are_found_before_any_work(tmp_path: Path, loop: Path) -> None:
    before = sorted(tmp_path.rglob("*"))
    for place in (
        tmp_path / ("x" * 300),
        tmp_path / "new" / ("x" * 300),
        loop,
        loop / "c",
        Path("/dev/full"),
        Path("a\0"),
    ):
        with pytest.raises(FileError, match=r"cannot be written: .*; choose another place"):
            require_writable_folder(place)
    for place in (tmp_path / ("x" * 250), loop, Path("/dev/full"), tmp_path):
        with pytest.raises(FileError):
            require_writable_file(place)
    require_writable_folder(tmp_path / "one" / "two")
    require_writable_file(tmp_path / "one" / "two.npz")
    assert sorted(tmp_path.rglob("*")) == before, "nothing is left behind"


def test_looking_a_place_up(tmp_path: Path, loop: Path) -> None:
    assert not is_file(tmp_path / "nothing")
    assert not is_file(tmp_path)
    for place in (tmp_path / ("x" * 300), loop, Path("a\0")):
        with pytest.raises(FileError, match="cannot be looked up"):
            is_file(place)


def test_what_has_no_end_is_not_read_to_its_end() -> None:
    with pytest.raises(FileError, match="larger than 256 MiB"):
        Scene.load("/dev/zero")


# words of others


def test_what_c_prints_is_kept(capfd: pytest.CaptureFixture[str]) -> None:
    import ctypes

    libc = ctypes.CDLL(None)
    with Silenced() as printed:
        libc.puts(b"from C")
        libc.dprintf(2, b"Error:   joint 'j' is wrong. See the manual.\n")
    libc.puts(b"afterwards")
    libc.fflush(None)
    assert "from C" in printed.text
    assert printed.complaint() == "joint 'j' is wrong"
    assert capfd.readouterr() == ("afterwards\n", "")


def test_silence_ends_with_an_exception(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ZeroDivisionError), Silenced():
        _ = 1 / 0
    np.testing.assert_equal(capfd.readouterr(), ("", ""))


def test_whatever_is_quoted_is_short() -> None:
    assert shown("a.b") == "'a.b'"
    assert len(shown("x" * 10_000)) < 200
    assert len(shown([["x" * 100] * 100] * 100)) < 2000
    assert "thousands of digits" in shown(1 << 100_000)
    with pytest.raises(FileError):
        parse_yaml("!!timestamp x", "it")
    assert issubclass(SceneError, PlannerError)
