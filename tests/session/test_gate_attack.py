"""An optimiser against the gate: nothing that it calls safe touches, and it finds what is not proven."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.gate import judge
from benchmarks.gate.attack import Attack
from planner.kinematics.forward import Chain, joint_placements
from planner.robot.robot import Robot
from planner.robot.shapes import corners
from planner.session import verdict
from planner.session.gate import Gate
from planner.session.permissions import Permit
from planner.session.reasons import Violation, Where
from planner.session.verdict import Verdict
from tests.worlds import load


def attacked(robot: str, tries: int, seed: int = 1, aim: str = "safe") -> Attack:
    attack = Attack(load(robot), aim=aim)
    attack.run(tries, np.random.default_rng(seed))
    return attack


@pytest.mark.parametrize(("robot", "tries"), [("planar_2r", 200), ("panda", 24)])
def test_nothing_that_is_called_safe_touches_or_is_beyond_a_limit(robot: str, tries: int) -> None:
    found = attacked(robot, tries).found
    assert (found.tries, found.false, found.beyond) == (tries, [], 0)
    assert found.safe > tries // 10
    assert found.least < 0.02


@pytest.mark.parametrize(("aim", "tries"), [("allowed", 60), ("slowed", 90)])
def test_nothing_touches_beyond_an_allowed_contact_or_slowed(aim: str, tries: int) -> None:
    found = attacked("planar_2r", tries, aim=aim).found
    assert (found.tries, found.false, found.beyond) == (tries, [], 0)
    assert (found.safe if aim == "allowed" else found.slowed) > tries // 10
    assert found.least < 0.02


def test_nor_of_a_robot_that_slides_and_turns_without_end_and_has_fingers(tmp_path: Path) -> None:
    robot = Robot.load(urdf(tmp_path), tool="arm")
    attack = Attack(robot)
    attack.run(90, np.random.default_rng(2))
    found = attack.found
    assert (robot.joints, robot.continuous.tolist()) == (("slide", "turn"), [False, True])
    assert (found.false, found.beyond) == ([], 0)
    assert found.safe > 20


def urdf(folder: Path) -> Path:
    """A cart with an arm that turns, and two fingers of which one follows the other."""
    links = "".join(
        f'<link name="{name}"><collision><origin xyz="{at} 0 0"/>'
        f'<geometry><box size="{size}"/></geometry></collision></link>'
        for name, at, size in [
            ("base", 0, ".1 .1 .1"), ("cart", 0, ".2 .2 .1"), ("arm", 0.25, ".5 .04 .04"),
            ("left", 0, ".02 .02 .1"), ("right", 0, ".02 .02 .1"),
        ]
    )  # fmt: skip
    limit = '<limit lower="{}" upper="{}" velocity="1" effort="1"/>'
    joints = "".join(
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/>{limit.format(*ends)}{more}</joint>'
        for name, kind, parent, child, at, axis, ends, more in [
            ("slide", "prismatic", "base", "cart", "0 0 .2", "1 0 0", (-1, 1), ""),
            ("turn", "continuous", "cart", "arm", "0 0 .12", "0 0 1", (0, 0), ""),
            ("l", "prismatic", "arm", "left", ".5 .03 0", "0 1 0", (0, 0.05), ""),
            ("r", "prismatic", "arm", "right", ".5 -.03 0", "0 -1 0", (0, 0.05), '<mimic joint="l"/>'),
        ]
    )
    path = folder / "cart.urdf"
    path.write_text(f'<robot name="cart">{links}{joints}</robot>')
    return path


def overlook(monkeypatch: pytest.MonkeyPatch, left_out: Callable[[Violation], bool]) -> None:
    """Let the gate call safe what is bad for some reasons only."""
    whole = Gate.check

    def check(self: Gate, *asked: Any, **named: Any) -> Verdict:
        found = whole(self, *asked, **named)
        if found.reason is None or not left_out(found.reason):
            return found
        return replace(found, safe=True, reason=None, first_bad=None)

    monkeypatch.setattr(Gate, "check", check)


@pytest.mark.parametrize("left_out", ["motion", "stop"])
def test_it_finds_what_is_not_proven(monkeypatch: pytest.MonkeyPatch, left_out: Where) -> None:
    overlook(monkeypatch, lambda reason: reason.on == left_out and reason.kind != "limit")
    assert any(attacked("planar_2r", 36, seed).found.false for seed in range(1, 5))


def test_it_finds_contacts_that_are_not_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Permit, "first_broken", lambda *_: None)
    assert any(attacked("planar_2r", 36, seed, "allowed").found.false for seed in range(1, 5))


def test_it_finds_slowed_chunks_that_touch(monkeypatch: pytest.MonkeyPatch) -> None:
    judge_chunk = verdict.judge_chunk

    def overlook_stops(*asked: Any) -> Verdict:
        found = judge_chunk(*asked)
        is_stop = found.reason is not None and found.reason.on == "stop"
        return replace(found, safe=True, reason=None, first_bad=None) if is_stop else found

    monkeypatch.setattr(verdict, "judge_chunk", overlook_stops)
    assert any(attacked("planar_2r", 36, seed, "slowed").found.false for seed in range(1, 5))


def test_it_finds_limits_that_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    overlook(monkeypatch, lambda reason: reason.kind == "limit")
    assert any(attacked("planar_2r", 36, seed).found.beyond for seed in range(1, 5))


@pytest.mark.parametrize("name", ["planar_2r", "panda", "ur5"])
def test_no_point_moves_farther_than_the_judge_takes_for_possible(name: str) -> None:
    robot, rng = load(name), np.random.default_rng(5)
    reach, chain = judge.reach_of(robot), Chain.from_arm(robot)
    q = rng.uniform(np.maximum(robot.lower, -3.0), np.minimum(robot.upper, 3.0), (40, robot.dof))
    for body, bound in zip(robot.bodies, reach, strict=True):
        points = corners(body.shape)[0] @ body.placement[:3, :3].T + body.placement[:3, 3]
        for j in range(robot.dof):
            step = 1e-6 * np.eye(robot.dof)[j]
            (before, at), (after, there) = (joint_placements(chain, q + way * step) for way in (-1, 1))
            moved = (after - before)[body.joint] @ points.T + (there - at)[body.joint][..., None]
            assert np.linalg.norm(moved, axis=1).max() / 2e-6 <= bound[j] + 1e-6
