"""What is proven of a trajectory."""

from __future__ import annotations

import numpy as np
import pytest

from planner.collision.edge_prover import EdgeProver
from planner.trajectory.proof import prove_motion
from planner.trajectory.trajectory import Trajectory
from tests.trajectory.test_check import ARM, CHECKER, LIMITS


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
