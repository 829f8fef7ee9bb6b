"""Certificates of plans: whole, accepted by the checker of one file, refused where the world is another one."""

import ast
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.attack.certificates.folders import AROUND, folder_of
from benchmarks.attack.certificates.judge import closest
from benchmarks.attack.certificates.mutations import Case
from planner.certificate import PROOF_NAME, make_certificate, make_motion_certificate, verify, verify_proof
from planner.certificate.verify_proof import Refused
from planner.collision import make_checker
from planner.planning.plan import plan
from planner.problem.request import PlanRequest, TimingRequest
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Mesh, Obstacle
from planner.trajectory.timing import time_path
from tests.worlds import UR3, joint_xml, link_xml, load, make_post, scene_of

LINES = 600
TOOL = Path(__file__).resolve().parents[2] / "tools" / "verify_proof.py"


@pytest.mark.parametrize(("robot", "scene"), [("iiwa14", "paper"), ("panda", "table"), ("ur5", "table")])
def test_plans_are_certified_and_accepted(robot: str, scene: str, tmp_path: Path) -> None:
    found = plan(
        request=PlanRequest.from_options(robot=robot, scene=scene, path_only=True, refinement_rounds=0),
        timing=TimingRequest(),
    )
    assert found.solved
    found.save_without_page(tmp_path, certificate=True)
    said = verify(tmp_path, found.checker.world)
    ends = f"{found.path[0].tolist()} to {found.path[-1].tolist()}"
    assert f"path of {len(found.path)} waypoints from {ends} and of the motion" in said
    assert "Joints and shapes are those of" in said
    assert (tmp_path / PROOF_NAME).stat().st_size < 5e6
    found.save_without_page(tmp_path)
    assert not (tmp_path / PROOF_NAME).exists(), "a proof of another plan is not left behind"


def test_the_checker_is_one_short_file_that_needs_numpy_alone(tmp_path: Path) -> None:
    text = TOOL.read_text()
    assert len(text.splitlines()) <= LINES
    tree = ast.walk(ast.parse(text))
    names = {a.name for node in tree if isinstance(node, ast.Import) for a in node.names}
    names |= {str(node.module) for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)}
    assert {name.split(".")[0] for name in names} - set(sys.stdlib_module_names) == {"numpy"}
    folder, _ = folder_of(tmp_path / "out", make_post(), AROUND)
    run = subprocess.run([sys.executable, "-I", TOOL, folder], capture_output=True, text=True, cwd=tmp_path)
    assert (run.returncode, run.stdout[:7]) == (0, "Proven:"), run.stderr
    bare = subprocess.run([sys.executable, "-I", TOOL, tmp_path], capture_output=True, text=True, cwd=tmp_path)
    assert (bare.returncode, bare.stderr) == (
        1,
        f"NOT proven: {tmp_path / PROOF_NAME} not found: plan with --certificate to write it.\n",
    )
    (folder / "plan.json").write_text("{}")
    run = subprocess.run([sys.executable, "-I", TOOL, folder], capture_output=True, text=True, cwd=tmp_path)
    assert (run.returncode, run.stderr[:10]) == (1, "NOT proven")


def test_a_motion_is_certified_and_its_limits_are_judged(tmp_path: Path) -> None:
    checker = make_post()
    motion = time_path(AROUND, checker)
    certificate = make_motion_certificate(checker, motion)
    assert certificate.is_complete
    assert len(certificate.arrays["clock"]) == len(motion.times)
    folder, _ = folder_of(tmp_path / "out", checker, AROUND, motion)
    assert "velocity, acceleration, jerk" in verify_proof.check(folder)
    assert motion.limits is not None
    worst = motion.worst(2, motion.limits.acceleration)[0]
    for share, accepted in ((worst, True), (worst * (1 - 1e-5), False)):
        limits = replace(motion.limits, acceleration=share * motion.limits.acceleration)
        folder_of(tmp_path / "out", checker, AROUND, replace(motion, limits=limits))
        if accepted:
            verify_proof.check(folder)
        else:
            with pytest.raises(Refused, match="acceleration exceeds its limit"):
                verify_proof.check(folder)


def test_an_obstacle_that_was_moved_is_another_world(tmp_path: Path) -> None:
    checker = make_post()
    scene = checker.world.scene
    folder, _ = folder_of(tmp_path / "out", checker, AROUND)
    verify(folder, checker.world)
    for far in (0.2, 1e-12):
        post = replace(scene.obstacles[0], placement=scene.obstacles[0].placement @ pose([far, 0, 0]))
        moved = make_checker(checker.robot, replace(scene, obstacles=(post,)))
        with pytest.raises(Refused, match=r"than plan\.json"):
            verify(folder, moved.world)
    through = np.array([[-1.0, 0.0], [1.0, 0.0]])
    _, certificate = folder_of(tmp_path / "out", checker, through)
    assert any("thing0" in pair for pair in certificate.open_pairs)
    with pytest.raises(Refused, match=r"'thing0' are not proven apart.*hulls"):
        verify_proof.check(folder)


def test_a_mesh_with_dents_is_cut_into_slabs_where_its_hull_is_too_close(tmp_path: Path) -> None:
    """Between two walls of one mesh no plane separates the arm from the hull of both."""
    wall = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.01, 0.01) for z in (-0.1, 0.1)])
    aside = np.array([0, 0.3, 0])
    sides = "013 032 475 467 051 045 237 276 026 064 157 173"
    triangles = np.array([[int(k) for k in side] for side in sides.split()])
    mesh = Mesh(np.concatenate([wall - aside, wall + aside]), np.concatenate([triangles, triangles + 8]))
    checker = make_checker(load("planar_2r"), Scene("notch", (Obstacle("walls", mesh, pose([0.8, 0, 0])),)))
    folder, certificate = folder_of(tmp_path / "out", checker, np.array([[0.0, 0.0], [0.05, 0.0]]))
    assert certificate.meta["cuts"] == {"walls": 8}
    assert certificate.is_complete
    assert "Robot, scene" in verify(folder, checker.world)
    _, certificate = folder_of(tmp_path / "out", checker, np.array([[0.0, 0.0], [0.6, 0.0]]))
    assert not certificate.is_complete
    assert all("walls" in second for _, second in certificate.open_pairs)
    with pytest.raises(Refused, match=r"'walls, slab \d+' are not proven apart"):
        verify_proof.check(folder)


def test_the_urdf_counts_where_it_is_given(tmp_path: Path) -> None:
    checker = make_post()
    folder, _ = folder_of(tmp_path / "out", checker, AROUND)
    text, copy = checker.robot.source.path.read_text(), tmp_path / "arm.urdf"
    copy.write_text(text)
    assert "Joints and shapes are those of arm.urdf." in verify_proof.check(folder, copy)
    for changed in (
        text.replace('<axis xyz="0 0 1"', '<axis xyz="0 1 0"'),
        text.replace('<origin xyz="0.5 0 0"/>', '<origin xyz="1.5 0 0"/>'),
        text.replace('lower="-2.9670597283903604', 'lower="0.9'),
        text.replace('radius="0.025" length="0.375"', 'radius="0.025" length="0.9"'),
        text.replace('name="joint_1"', 'name="another"'),
        "<robot",
    ):
        assert changed != text
        copy.write_text(changed)
        with pytest.raises(Refused):
            verify_proof.check(folder, copy)
    with pytest.raises(Refused):
        verify_proof.check(folder, load("panda").source.path)


def test_pieces_of_meshes_are_certified_and_said_not_to_be_compared(tmp_path: Path) -> None:
    checker = make_checker(Robot.load(UR3), Scene("none"))
    path = np.array([[0.0, -1.2, 1.2, -1.5, -1.5, 0.0], [0.2, -1.1, 1.1, -1.4, -1.5, 0.2]])
    folder, certificate = folder_of(tmp_path / "out", checker, path)
    assert certificate.is_complete
    assert any("piece 2" in name for name in certificate.meta["items"])
    said = verify_proof.check(folder, Path(UR3))
    assert "meshes not found, cut or of another kind: " in said
    assert "'wrist_1_link_0'" in said
    urdf = tmp_path / "ur3.urdf"
    text = Path(UR3).read_text()
    urdf.write_text(text.replace("shoulder_link", "moved").replace("wrist_3_link", "shoulder_link"))
    with pytest.raises(Refused, match="hangs on another joint"):
        verify_proof.check(folder, urdf)


def test_joints_that_slide_or_turn_for_good_are_certified(tmp_path: Path) -> None:
    """Held against distances by another method; a path that is nearer than it says is refused."""
    bar = '<box size="0.2 0.02 0.02"/>'
    links = link_xml("base") + link_xml("one", bar) + link_xml("two", bar)
    turning = joint_xml("first", "base", "one", "continuous")
    sliding = joint_xml("second", "one", "two", "prismatic", axis="1 0 0", xyz="0.25 0 0", limit="0 0.4")
    urdf = tmp_path / "made.urdf"
    urdf.write_text(f'<robot name="made">{links}{turning}{sliding}</robot>')
    scene = scene_of((Box((0.1, 0.1, 0.1)), pose([0, 0.6, 0])))
    checker = make_checker(Robot.load(urdf), scene, margin=0.01)
    path = np.array([[0.0, 0.3], [1.0, 0.0], [2.1, 0.1], [9.0, 0.05]])
    folder, certificate = folder_of(tmp_path / "out", checker, path)
    assert certificate.is_complete
    assert "Joints and shapes" in verify_proof.check(folder, urdf)
    case = Case.from_folder(folder)
    near = closest(case.data, 300, np.random.default_rng(0), 1.0)
    assert near > 0.01
    assert not case.accepts({**case.data, "margin": np.array(near + 1e-6)}, case.meta)
    assert not make_certificate(checker, np.array([[0.0, 0.3], [2.1, 0.3]])).is_complete
