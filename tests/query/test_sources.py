"""The hash of a request changes with every file that is read for it, and with nothing else."""

import os
from pathlib import Path

import pytest

from planner.problem.request import SweepRequest
from planner.query.robots import robot_sources, scene_sources, sources_hash
from tests.worlds import joint_xml, link_xml

TRIANGLES = "".join(f"f {face}\n" for face in ("1 3 2", "1 2 4", "2 3 4", "1 4 3"))
TETRAHEDRON = f"v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n{TRIANGLES}"
SCENE = (
    "obstacles: [{name: a, type: mesh, file: parts/a.obj}]\ncarried: [{name: b, type: mesh, file: b.obj, link: fore}]\n"
)
CHANGES = {  # file: (what is changed in it, into what)
    "robot/robot.yaml": ("home: [0, 0]", "home: [0, 1]"),
    "robot/arm.urdf": ('upper="1"', 'upper="1.1"'),
    "robot/arm.srdf": ('link2="fore"', 'link2="tip"'),
    "robot/meshes/upper.obj": ("v 0 0 0.1", "v 0 0 0.2"),
    "robot/meshes/seen.obj": ("v 0 0 0.1", "v 0 0 0.2"),
    "scene.yaml": ("name: a", "name: c"),
    "parts/a.obj": ("v 0.1 0 0", "v 0.3 0 0"),
    "b.obj": ("v 0.1 0 0", "v 0.3 0 0"),
    "request.yaml": ("0.5", "0.6"),
    "roadmap.npz": ("grown", "other"),
}


@pytest.fixture
def request_of_files(tmp_path: Path) -> SweepRequest:
    seen = '<visual><geometry><mesh filename="meshes/seen.obj"/></geometry></visual>'
    upper = link_xml("upper", '<mesh filename="package://robot/meshes/upper.obj"/>').replace(
        "</link>", seen + "</link>"
    )
    joints = joint_xml("shoulder", "base", "upper") + joint_xml("elbow", "upper", "fore", xyz="0.4 0 0")
    files = {
        "robot/robot.yaml": "urdf: {file: arm.urdf}\nsrdf: {file: arm.srdf}\nhome: [0, 0]\n",
        "robot/arm.urdf": f'<robot name="arm">{link_xml("base")}{upper}{link_xml("fore")}{joints}</robot>',
        "robot/arm.srdf": '<robot name="arm"><disable_collisions link1="upper" link2="fore"/></robot>',
        "robot/meshes/upper.obj": TETRAHEDRON,
        "robot/meshes/seen.obj": TETRAHEDRON,
        "scene.yaml": SCENE,
        "parts/a.obj": TETRAHEDRON,
        "b.obj": TETRAHEDRON,
        "request.yaml": "start_state: {joint_state: {name: [shoulder], position: [0.5]}}",
        "roadmap.npz": "grown",
        "other.srdf": '<robot name="arm"/>',
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    request, roadmap = tmp_path / "request.yaml", tmp_path / "roadmap.npz"
    return SweepRequest.from_options(
        robot=str(tmp_path / "robot"), scene=str(tmp_path / "scene.yaml"), motion_plan_request=request, roadmap=roadmap
    )


@pytest.mark.parametrize("name", CHANGES)
def test_every_file_that_is_read_counts(name: str, request_of_files: SweepRequest, tmp_path: Path) -> None:
    path, (old, new) = tmp_path / name, CHANGES[name]
    before, text = sources_hash(request_of_files), path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    os.utime(path, ns=(1, 1))  # the clock of a file system may be too coarse to tell two writes apart
    assert sources_hash(request_of_files) != before
    path.write_text(text)
    assert sources_hash(request_of_files) == before
    path.unlink()
    assert sources_hash(request_of_files) != before


def test_files_of_the_package_count_and_missing_files_are_left_to_the_plan() -> None:
    found = {
        sources_hash(SweepRequest.from_options(robot=robot, scene=scene))
        for robot in ("panda", "ur5")
        for scene in ("shelf", "table")
    }
    assert len(found) == 4
    assert sources_hash(SweepRequest.from_options(robot="nowhere", scene="nowhere.yaml"))
    names = {path.name for path in (*robot_sources("panda"), *scene_sources("shelf"))}
    assert {"robot.yaml", "panda.urdf", "panda.srdf", "shelf.yaml"} < names
    assert any(name.endswith((".stl", ".obj", ".dae")) for name in names)
