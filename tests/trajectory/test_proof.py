"""What is proven of a trajectory."""

from __future__ import annotations

import numpy as np
import pytest

from planner.collision.edge_prover import EdgeProver
from planner.trajectory.proof import limits_exceeded, prove_motion
from planner.trajectory.report import report_record
from planner.trajectory.trajectory import Trajectory
from tests.trajectory.test_check import ARM, CHECKER, LIMITS, report_of


def test_excess_is_exact() -> None:
    """From rest to rest over d in T a cubic accelerates by 6 d / T² at its ends and runs at 1.5 d / T in the middle."""
    report = report_of([0.0, 0.4], [[-0.6, 0.0], [-0.3, 0.0]], [[0.0, 0.0], [0.0, 0.0]])
    assert report.proof is not None
    excess = report.proof.excesses[0]
    assert (excess.kind, excess.joint, excess.limit) == ("acceleration", "joint_1", 5.0)
    assert excess.value == pytest.approx(6 * 0.3 / 0.4**2)
    assert report_record(report)["shares"]["velocity"] == pytest.approx(1.5 * 0.3 / 0.4 / 2.0)


def test_a_motion_through_something_is_not_free_and_the_pair_is_named() -> None:
    through = Trajectory.through(
        ARM.joints, np.array([0.0, 4.0]), np.array([[-1.0, 0.0], [1.5, 0.0]]), np.zeros((2, 2))
    )
    proof = prove_motion(through, EdgeProver(CHECKER), LIMITS)
    assert not proof.free
    assert not proof.whole
    first, _ = CHECKER.world.members(int(proof.pair[0]))
    assert CHECKER.world.bodies[first].joint > 0
    record = proof.to_dict(0.0, "fcl")
    assert (record["pieces"], record["pieces_free"], record["limits_exceeded"]) == (1, 0, [])
    assert "floor" not in record


def test_a_floor_is_asked_of_what_lies_between_its_knots_only() -> None:
    """w of planar_2r is l1 l2 |sin q2|: the motion begins and ends stretched out, and dips in its middle or not."""
    knots, quick = np.array([0.0, 2.0, 4.0, 6.0]), EdgeProver(CHECKER)
    for middle, holds in ((1.4, True), (0.0, False)):
        q = np.array([[-1.0, 0.05], [-1.0, 1.0], [-1.1, middle], [-1.0, 1.0], [-1.0, 0.05]])
        found = prove_motion(
            Trajectory.through(ARM.joints, np.append(knots, 8.0), q, np.zeros_like(q)), quick, LIMITS, floor=0.1
        )
        assert found.floor_holds[[0, 3]].all(), "nothing is asked of the ways up and down"
        assert bool(found.floor_holds[1:3].all()) == holds
        below = int((~found.floor_holds).sum())
        record = {"asked": 0.1, "pieces_above": 2 - below, "pieces_exempt": 2, "pieces_below": below, "proven": holds}
        assert found.to_dict(0.0, "fcl")["floor"] == record
        assert found.free


@pytest.mark.parametrize("reaching", [0, 1])
def test_of_a_floor_that_no_piece_reaches_nothing_is_proven(reaching: int) -> None:
    """One knot above is no piece: 53 of 53 pieces were said to be above a floor that w never came near."""
    q = np.array([[-1.0, 0.05], [-1.0, 1.0 if reaching else 0.06], [-1.0, 0.05]])
    made = Trajectory.through(ARM.joints, np.array([0.0, 4.0, 8.0]), q, np.zeros_like(q))
    found = prove_motion(made, EdgeProver(CHECKER), LIMITS, floor=0.1)
    record = found.to_dict(0.0, "fcl")["floor"]
    assert record == {"asked": 0.1, "pieces_above": 0, "pieces_exempt": 2, "pieces_below": 0, "proven": False}
    assert found.floor_holds.all(), "nothing was asked"


def test_every_kind_of_limit_is_judged_by_exact_extrema() -> None:
    """A cubic from rest to rest over 1 rad in T s: velocity 1.5 / T, acceleration 6 / T², jerk 12 / T³."""
    for T in (0.3, 3.0):
        q = np.array([[0.0, 0.0], [1.0, 0.0]])
        made = Trajectory.through(ARM.joints, np.array([0.0, T]), q, np.zeros((2, 2)))
        broken = {excess.kind: excess.value for excess in limits_exceeded(made, ARM, LIMITS)}
        truth = {"velocity": 1.5 / T, "acceleration": 6 / T**2, "jerk": 12 / T**3}
        assert broken == pytest.approx({k: v for k, v in truth.items() if v > getattr(LIMITS, k)[0]}, rel=1e-9)
    outside = Trajectory.through(ARM.joints, np.array([0.0, 9.0]), np.array([[0.0, 0], [0.0, 9.0]]), np.zeros((2, 2)))
    (excess,) = (e for e in limits_exceeded(outside, ARM, LIMITS) if e.kind == "position")
    assert (excess.joint, excess.value, excess.limit) == (ARM.joints[1], 9.0, ARM.upper[1])
