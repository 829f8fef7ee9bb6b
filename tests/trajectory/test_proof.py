"""What is proven of a trajectory; limits against closed forms, jumps against differences on both sides of points."""

from dataclasses import replace

import numpy as np
import pytest

from planner.collision.edge_prover import EdgeProver
from planner.trajectory.proof import find_limit_violations, largest_jump, prove_motion
from planner.trajectory.trajectory import Trajectory
from tests.trajectory.test_check import ARM, CHECKER, LIMITS
from tests.trajectory.test_export import MADE


def test_a_motion_through_something_is_not_free_and_the_pair_is_named() -> None:
    through = Trajectory.from_points(
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
            Trajectory.from_points(ARM.joints, np.append(knots, 8.0), q, np.zeros_like(q)), quick, LIMITS, floor=0.1
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
    made = Trajectory.from_points(ARM.joints, np.array([0.0, 4.0, 8.0]), q, np.zeros_like(q))
    found = prove_motion(made, EdgeProver(CHECKER), LIMITS, floor=0.1)
    record = found.to_dict(0.0, "fcl")["floor"]
    assert record == {"asked": 0.1, "pieces_above": 0, "pieces_exempt": 2, "pieces_below": 0, "proven": False}
    assert found.floor_holds.all(), "nothing was asked"


TIMES = np.array([0.0, 0.3, 0.45, 1.1, 1.9])
RNG = np.random.default_rng(5)
Q = RNG.normal(size=(5, 2))
QD = np.concatenate([np.zeros((1, 2)), RNG.normal(size=(3, 2)), np.zeros((1, 2))])


@pytest.mark.parametrize(("columns", "what", "order"), [((Q,), "velocity", 1), ((Q, QD), "acceleration", 2)])
def test_the_largest_is_the_one_that_differences_find(columns: tuple, what: str, order: int) -> None:
    made = Trajectory.from_points(ARM.joints, TIMES, *columns)
    apart = 1e-7
    before, after = (made.at(TIMES + sign * apart, order) for sign in (-1, 1))
    after[-1] = 0.0  # it stands then
    before[0] = after[0] if what == "velocity" else 0.0
    size = np.abs(after - before)
    k, joint = np.unravel_index(int((size / getattr(LIMITS, what)).argmax()), size.shape)
    jump = largest_jump(made, LIMITS)
    assert jump is not None
    assert (jump.what, jump.joint, jump.time) == (what, ARM.joints[joint], TIMES[k])
    assert jump.size == pytest.approx(size[k, joint], rel=1e-4)
    assert jump.count == (size > 1e-3).any(axis=1).sum()
    assert jump.infinite == ("acceleration", "jerk")[order - 1 :]


def test_what_we_make_does_not_jump_and_standing_does_not_either() -> None:
    assert largest_jump(MADE, LIMITS) is None
    still = np.repeat(Q[:1], 5, axis=0)
    for columns in ((still,), (still, 0.0 * still)):
        assert largest_jump(Trajectory.from_points(ARM.joints, TIMES, *columns), LIMITS) is None


def test_a_straight_line_of_many_points_jumps_at_its_ends_only() -> None:
    """Rounded positions 1 ms apart are no jumps of velocities, nor of the accelerations of cubics."""
    t = np.arange(2001) / 1000.0
    q = np.stack([3.0 + 0.1 * t, 1.0 - 0.2 * t], axis=1)
    jump = largest_jump(Trajectory.from_points(ARM.joints, t, q), LIMITS)
    assert jump is not None
    assert (jump.time, jump.count) == (2.0, 1), "before it begins the robot may move already"
    qd = np.repeat([[0.1, -0.2]], len(t), axis=0)
    qd[-1] = 0.0
    jump = largest_jump(Trajectory.from_points(ARM.joints, t, q, qd), LIMITS)
    assert jump is not None
    assert jump.count == 2, "those of the last piece, which brakes within a millisecond"


def test_an_end_that_still_accelerates_jumps() -> None:
    bent = MADE.columns[2].copy()
    bent[-1] = [0.0, 1.0]
    jump = largest_jump(replace(MADE, columns=(*MADE.columns[:2], bent)), LIMITS)
    assert jump is not None
    assert (jump.what, jump.joint, jump.size, jump.time) == ("acceleration", ARM.joints[1], 1.0, MADE.times[-1])


def test_every_kind_of_limit_is_judged_by_exact_extrema() -> None:
    """A cubic from rest to rest over 1 rad in T s: velocity 1.5 / T, acceleration 6 / T², jerk 12 / T³."""
    for T in (0.3, 3.0):
        q = np.array([[0.0, 0.0], [1.0, 0.0]])
        made = Trajectory.from_points(ARM.joints, np.array([0.0, T]), q, np.zeros((2, 2)))
        broken = {each.what[0]: each.value for each in find_limit_violations(made, ARM, LIMITS)}
        truth = {"velocity": 1.5 / T, "acceleration": 6 / T**2, "jerk": 12 / T**3}
        assert broken == pytest.approx({k: v for k, v in truth.items() if v > getattr(LIMITS, k)[0]}, rel=1e-9)
    outside = Trajectory.from_points(
        ARM.joints, np.array([0.0, 9.0]), np.array([[0.0, 0], [0.0, 9.0]]), np.zeros((2, 2))
    )
    (found,) = (each for each in find_limit_violations(outside, ARM, LIMITS) if each.what[0] == "position")
    assert (found.kind, found.what[1], found.value, found.allowed) == ("limit", ARM.joints[1], 9.0, ARM.upper[1])
