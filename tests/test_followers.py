"""Joints that follow others, against Pinocchio and coal, from kinematics to certificates and the gate."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.attack.certificates.folders import folder_of
from benchmarks.attack.certificates.judge import closest, least_w
from benchmarks.attack.certificates.mutations import Case
from benchmarks.gate.attack import Attack
from planner.base.polynomials import evaluate
from planner.certificate import verify, verify_proof
from planner.certificate.verify_proof import Refused
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver, Verdict
from planner.kinematics.forward import Chain, joint_placements, tool_pose
from planner.kinematics.manipulability import manipulability, node_manipulability
from planner.planning.plan import plan
from planner.planning.result import Plan
from planner.problem.outcome import Outcome
from planner.problem.request import PlanRequest, TimingRequest
from planner.robot.poses import pose
from planner.robot.reach import Reach
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Sphere
from tests.kinematics.test_reach import some_points
from tests.linkages import PALLETIZER, Linkage, palletizer, random_linkage
from tests.random_shapes import random_pose
from tests.refusals import refusal_of
from tests.worlds import joint_xml, link_xml, random_q, scene_of

SEEDS = range(3)
LINKAGES = ["palletizer", *SEEDS]


def linkage(which: str | int) -> Linkage:
    return random_linkage(which) if isinstance(which, int) else palletizer()


@pytest.mark.parametrize("which", LINKAGES)
def test_links_are_where_pinocchio_has_them(which: str | int) -> None:
    made = linkage(which)
    robot = made.robot
    assert robot.followers
    assert len(robot.joints) == len(robot.model.names) - 1 - len(robot.followers)
    q = random_q(robot, 10)
    rotation, position = joint_placements(Chain.from_arm(robot), q)
    for k, row in enumerate(q):
        for name, there in made.frames(row).items():
            frame = robot.model.frames[robot.model.getFrameId(name, pin.FrameType.BODY)]
            turn, shift = rotation[frame.parentJoint, k], position[frame.parentJoint, k]
            np.testing.assert_allclose(turn @ frame.placement.rotation, there[:3, :3], atol=1e-12)
            np.testing.assert_allclose(turn @ frame.placement.translation + shift, there[:3, 3], atol=1e-12)
        np.testing.assert_allclose(tool_pose(robot, row).homogeneous, made.frames(row)[robot.tool], atol=1e-12)


@pytest.mark.parametrize("which", LINKAGES)
def test_followers_add_to_their_leaders_columns_of_the_jacobian(which: str | int) -> None:
    made, h = linkage(which), 1e-6
    robot = replace(made.robot, jacobian_rows="pose")
    for q in random_q(robot, 3, seed=1):
        columns = []
        for step in h * np.eye(robot.dof):
            ahead, behind = (made.frames(q + by)[robot.tool] for by in (step, -step))
            turn = ahead[:3, :3] @ behind[:3, :3].T
            angular = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
            columns.append(np.concatenate([ahead[:3, 3] - behind[:3, 3], angular]) / (2 * h))
        found = np.array(columns).T
        np.testing.assert_allclose(robot.jacobian(q), found, atol=1e-8)
        w = np.linalg.svd(found, compute_uv=False).prod()
        np.testing.assert_allclose([manipulability(robot, q)[0], node_manipulability(robot, q)[0]], w, atol=1e-7)


def among(made: Linkage, seed: int) -> Scene:
    """Boxes and balls within reach."""
    rng = np.random.default_rng(seed)
    things = [Box((0.2, 0.15, 0.01)), Sphere(0.06), Box((0.02, 0.02, 0.5)), Sphere(0.02)]
    reach = 0.9 if made is palletizer() else 0.6
    return scene_of(*((shape, random_pose(rng, reach)) for shape in things))


def curves_of(robot: Robot, count: int, degree: int, seed: int) -> np.ndarray:
    """Random curves (n, degree + 1, dof), within limits."""
    rng, span = np.random.default_rng(seed), robot.upper - robot.lower
    start = 0.5 * (robot.lower + robot.upper) + span * rng.uniform(-0.3, 0.3, (count, robot.dof))
    steps = span * rng.uniform(-0.2 / degree, 0.2 / degree, (count, degree, robot.dof))
    return np.concatenate([start[:, None], steps], axis=1)


def along(curve: np.ndarray, count: int = 80) -> np.ndarray:
    return evaluate(np.repeat(curve[None], count, axis=0), np.linspace(0.0, 1.0, count))


@pytest.mark.parametrize("which", LINKAGES)
def test_proven_free_means_that_coal_finds_no_contact(which: str | int) -> None:
    """Straight and cubic motions; a motion that collides comes near a contact between two samples."""
    made, verdicts = linkage(which), np.zeros(3, dtype=int)
    scene = among(made, LINKAGES.index(which))
    for backend, degree in (("fcl", 1), ("coal", 3)):
        checker = make_checker(made.robot, scene, backend)
        curves = curves_of(made.robot, 40, degree, degree)
        proofs, prover = EdgeProver(checker).prove_curves(curves), EdgeProver(checker)
        for curve, verdict in zip(curves, proofs.verdict, strict=True):
            gap = made.nearest(checker.world, along(curve))
            assert gap > 0 or verdict != Verdict.FREE
            assert gap < 0.02 or verdict != Verdict.COLLIDES
            verdicts[verdict] += 1
            assert prover.all_free(curve[None]) == (verdict == Verdict.FREE)
    assert verdicts[Verdict.FREE] > 5
    assert verdicts[Verdict.COLLIDES] > 1
    assert verdicts[Verdict.UNDECIDED] < 8


BALL = scene_of((Sphere(0.03), pose([-0.306, 0.0, 0.868])))


NARROWED = [  # kind of the leader, the follower's kind, limits, <mimic>; what the leader is kept to, None refused
    ("revolute", "revolute", (-9, 9), "", (-2, 2, 1, False)),
    ("revolute", "revolute", (-1, 2), 'multiplier="-2" offset="0.5"', (-0.75, 0.75, 0.5, False)),
    ("revolute", "prismatic", (0, 0.5), 'multiplier="0.25"', (0, 2, 1, False)),
    ("revolute", "continuous", (0, 0), 'multiplier="3"', (-2, 2, 1 / 3, False)),
    ("continuous", "continuous", (0, 0), 'multiplier="-2"', (-np.pi, np.pi, 0.5, True)),
    ("continuous", "continuous", (0, 0), 'multiplier="0.5"', (-np.pi, np.pi, 1, False)),
    ("continuous", "revolute", (-9, 9), "", (-np.pi, np.pi, 1, False)),
    ("revolute", "revolute", (5, 9), "", None),
    ("revolute", "continuous", (0, 0), 'multiplier="1e3"', None),
]


@pytest.mark.parametrize(("leader", "kind", "limits", "said", "kept"), NARROWED)
def test_a_leader_has_the_limits_of_its_follower(leader, kind, limits, said, kept, urdf_file) -> None:
    joints = joint_xml("lead", "a", "b", leader, limit="-2 2") + joint_xml(
        "led", "a", "c", kind, limit="{} {}".format(*limits)
    )
    path = urdf_file("".join(map(link_xml, "abc")) + joints[:-8] + f'<mimic joint="lead" {said}/></joint>')
    if kept is None:
        assert "joint 'led' mimics 'lead' and cannot follow it" in refusal_of(lambda: Robot.load(path, tool="b"))
        return
    robot = Robot.load(path, tool="b")
    np.testing.assert_allclose([robot.lower[0], robot.upper[0], robot.velocity[0]], kept[:3], atol=1e-12)
    assert robot.continuous.tolist() == [kept[3]]
    same = kept[:3] == ((-2, 2, 1) if leader == "revolute" else (-np.pi, np.pi, 1)) and (
        leader == "revolute" or kept[3]
    )
    notes = [note for note in robot.notes if "'led'" in note.text]
    assert [note.text.startswith("joint 'led' follows 'lead', which is kept to") for note in notes] == [True] * (
        not same
    )


@pytest.mark.parametrize("which", LINKAGES)
def test_no_point_moves_further_than_its_reach(which: str | int) -> None:
    robot, rng = linkage(which).robot, np.random.default_rng(5)
    q = random_q(robot, 40)
    delta = random_q(robot, 40, seed=1) - q
    delta *= rng.choice([0.01, 0.3, 1.0], (40, 1)) * (rng.random(delta.shape) < 0.5)
    (turn, shift), (turned, shifted) = (joint_placements(Chain.from_arm(robot), rows) for rows in (q, q + delta))
    most = Reach.from_robot(robot).motion(delta)
    for k, body in enumerate(robot.bodies):
        points = some_points(body, rng)
        moved = points @ (turned - turn)[body.joint].transpose(0, 2, 1) + (shifted - shift)[body.joint][:, None]
        assert (np.linalg.norm(moved, axis=2).max(axis=1) <= most[:, k] + 1e-9).all()


# plans, certificates, the gate


@pytest.fixture(scope="module")
def planned() -> Plan:
    """From one side of the ball to the other, where the straight way leads the rod through it."""
    request = PlanRequest.from_options(
        robot=palletizer().robot, scene=BALL, start="q:-0.9,-0.4,0.2", goal="q:0.9,-0.4,0.2"
    )
    return plan(request=request, nodes=60, timing=TimingRequest())


def test_a_plan_and_its_motion_keep_the_rod_off_the_ball(planned: Plan) -> None:
    made = palletizer()
    assert planned.outcome is Outcome.SOLVED
    states = np.concatenate([along(np.stack([a, b - a]), 30) for a, b in itertools.pairwise(planned.path)])
    assert made.nearest(planned.checker.world, states) > 0
    assert planned.trajectory.joints == made.robot.joints == ("j1", "j2", "j3")
    times = np.linspace(planned.trajectory.times[0], planned.trajectory.times[-1], 300)
    assert made.nearest(planned.checker.world, planned.trajectory.at(times)) > 0


def case_of(folder: Path, planned: Plan) -> Case:
    folder_of(folder, planned.checker, planned.path, planned.trajectory, 1e-3)
    return Case.from_folder(folder)


def test_a_certificate_holds_and_false_ones_are_refused(planned: Plan, tmp_path: Path) -> None:
    """Also against the URDF: a rod that stands still or follows another joint belongs to another robot."""
    case, made = case_of(tmp_path / "out", planned), palletizer()
    said = verify_proof.check(case.folder, made.path)
    assert "Joints and shapes are those of linkage.urdf" in said
    assert verify(case.folder, planned.checker.world)
    rng = np.random.default_rng(0)
    assert closest(case.data, 20, rng, 1.0) > 0
    assert 1e-3 <= least_w(case.data, case.meta, 20) < np.inf
    for wrong in (
        PALLETIZER.replace('<mimic joint="j2"/>', '<mimic joint="j2" multiplier="0.5"/>'),
        PALLETIZER.replace('<mimic joint="j2"/>', '<mimic joint="j2" offset="0.4"/>'),
        PALLETIZER.replace('<mimic joint="j2"/>', '<mimic joint="j3"/>'),
        PALLETIZER.replace('<mimic joint="j2"/>', ""),
    ):
        (tmp_path / "linkage.urdf").write_text(wrong)
        with pytest.raises(Refused):
            verify_proof.check(case.folder, tmp_path / "linkage.urdf")
    rod = case.meta["tree"].index("rod_joint")
    for name, value in (("factor", 0.0), ("zero", 0.6), ("leader", 2)):
        data = {**case.data, name: case.data[name].copy()}
        data[name][rod] = value
        accepted = case.accepts(data, case.meta)
        assert accepted is None or closest(data, 20, rng, 1.0) > 0
        with pytest.raises(Refused, match=f"has another {name} than"):
            verify(case.folder, planned.checker.world)
    case.accepts(case.data, case.meta)


@pytest.mark.parametrize("which", ["palletizer", 6])
def test_nothing_that_the_gate_calls_safe_touches(which: str | int) -> None:
    attack = Attack(linkage(which).robot)
    attack.run(60, np.random.default_rng(1))
    assert (attack.found.false, attack.found.beyond) == ([], 0)
    assert attack.found.safe > 5
