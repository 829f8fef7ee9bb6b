"""The filter on arrays: safe actions pass to the last bit, and all others become a motion that coal finds free."""

import itertools
import logging

import numpy as np
import pytest

from planner.base.errors import ArrayError, OptionError, StateError
from planner.collision.coal import CoalChecker
from planner.lerobot import ActionFilter, Filtered
from planner.lerobot.action_filter import BEYOND, COMMAND, DIFFERENCES, FIRST, LAST
from planner.session.gate import Gate
from tests.lerobot.conftest import FPS, NAMES, Make, chunk_to

HOME = np.zeros(6)


def lines(found: Filtered, begin: np.ndarray = HOME, fine: int = 40) -> np.ndarray:
    """Configurations (n, 5) on the lines through all rows."""
    q = np.radians(np.vstack([begin, found.actions.reshape(-1, 6)])[:, :5])
    share = np.arange(fine)[:, None] / fine
    return np.vstack([a + share * (b - a) for a, b in itertools.pairwise(q)] + [q[-1:]])


def assert_free(gate: Gate, q: np.ndarray) -> None:
    """By coal, which the proofs do not use."""
    assert CoalChecker(gate.checker.world).first_contact(q) is None


def observed(actions: ActionFilter, *states: np.ndarray) -> ActionFilter:
    for state in states:
        actions.observe(state)
    return actions


@pytest.mark.parametrize("shape", [(1, 30, 6), (1, 6)])
def test_a_safe_chunk_passes_to_the_last_bit(shape: tuple[int, ...], make: Make) -> None:
    chunk = chunk_to(40.0)[:, :30].astype(np.float32).reshape(1, 30, 6)[:, : shape[1] if len(shape) == 3 else 1]
    chunk = chunk.reshape(shape)
    found = observed(make(), HOME).judge(chunk)
    assert (found.outcome, found.reason, found.proven) == ("safe", None, True)
    np.testing.assert_array_equal(found.actions, chunk)
    assert found.safe_until == pytest.approx(chunk.size / 6 / FPS)


@pytest.mark.parametrize("count", [15, 30, 60])
def test_a_chunk_into_a_wall_is_cut_and_stops(count: int, make: Make, gate: Gate) -> None:
    chunk = chunk_to(-80.0, count)
    found = observed(make(unsafe="stop"), HOME).judge(chunk)
    assert CoalChecker(gate.checker.world).first_contact(lines(Filtered(chunk, *[None] * 5))) is not None  # type: ignore[arg-type]
    assert (found.outcome, found.proven) == ("cut", True)
    assert "wall" in str(found.reason)
    kept = round(found.safe_until * FPS)
    np.testing.assert_allclose(found.actions[0, :kept], chunk[0, :kept], atol=1e-9)
    assert_free(gate, lines(found))
    np.testing.assert_array_equal(found.actions[0, :, 5], chunk[0, :, 5])  # the gripper
    np.testing.assert_allclose(found.actions[0, -1], found.actions[0, -2], atol=100 / count)
    assert np.ptp(found.actions[0, -3:, :5], axis=0).max() < 1e-9, "it rests"


def test_a_chunk_that_is_too_fast_is_slowed_and_the_gripper_with_it(make: Make, gate: Gate) -> None:
    chunk = chunk_to(60.0, 3)  # 20 degrees a row are 10.5 rad/s, and the limit is 10
    found = observed(make(rest="retime"), HOME).judge(chunk)
    assert (found.outcome, found.proven) == ("slowed", True)
    assert "velocity" in str(found.reason)
    count = found.actions.shape[1]
    assert count > 3
    np.testing.assert_allclose(found.actions[0, -1], chunk[0, -1], atol=1e-9)
    assert np.abs(np.diff(np.radians(found.actions[0, :, 0]), prepend=0.0)).max() * FPS <= 10.0 + 1e-6
    np.testing.assert_allclose(found.actions[0, :, 1:5], 0.0, atol=1e-9)
    passed = np.searchsorted(chunk[0, :, 0], found.actions[0, :, 0] - 1e-5)  # the row of the chunk that is under way
    np.testing.assert_array_equal(found.actions[0, :, 5], chunk[0, passed, 5])
    dropped = observed(make(), HOME).judge(chunk)
    np.testing.assert_array_equal(dropped.actions, found.actions[:, :3])
    assert observed(make(unsafe="stop"), HOME).judge(chunk).outcome == "cut"
    one = observed(make(rest="retime"), HOME).judge(chunk[:, 0])
    assert (one.outcome, one.actions.shape) == ("slowed", (1, 6)), "one action stays one"


def test_single_actions_without_an_observation_between_them_are_one_chunk(make: Make) -> None:
    """As the server of lerobot's asynchronous inference sends them."""
    for pan in (40.0, -80.0):
        chunk = chunk_to(pan)
        whole = observed(make(unsafe="stop"), HOME).judge(chunk)
        single = observed(make(unsafe="stop"), HOME)
        rows = np.vstack([single.judge(row[None]).actions for row in chunk[0]])
        until = round(whole.safe_until * FPS)
        np.testing.assert_allclose(rows[:until], whole.actions[0, :until], atol=1e-9)


@pytest.mark.parametrize("unsafe", ["slow", "stop"])
def test_one_action_after_the_other_never_touches_and_does_not_sink(unsafe: str, make: Make, gate: Gate) -> None:
    """A servo that lags, and that hangs 3 degrees below its target, pushed against a wall for five seconds."""
    actions, checker = make(unsafe=unsafe), CoalChecker(gate.checker.world)
    q, sag, sent = HOME.copy(), np.array([0, 3.0, 0, 0, 0, 0]), []
    for _ in range(150):
        actions.observe(q)
        wish = np.array([-80.0, 0, 0, 0, 0, 50.0])
        target = np.clip(wish, q - 5.0, q + 5.0)  # as a policy that sees where the arm is
        sent.append(actions.judge(target[None]).actions[0])
        q = q + 0.5 * (sent[-1] + sag - q)
        q[5] = sent[-1][5]
        assert checker.first_contact(np.radians(sent[-1][None, :5])) is None
    assert actions.counts["safe"] > 5
    assert actions.counts["cut"] + actions.counts["slowed"] > 50
    assert actions.counts["held"] == 0
    np.testing.assert_allclose(sent[-1][1:5], sent[-40][1:5], atol=0.5)
    assert sent[-1][0] < -10.0, "it went on until it was near"


def test_velocity_is_the_difference_of_observations(make: Make, gate: Gate) -> None:
    """A robot that moves needs a way to stop: near the wall a single safe target is unsafe with speed."""
    slow = observed(make(unsafe="stop"), HOME).judge(chunk_to(0.0, 1))
    assert slow.notes[0] == FIRST
    moving = observed(make(unsafe="stop"), np.array([4.0, 0, 0, 0, 0, 0]), HOME)
    assert moving.judge(chunk_to(-60.0, 4)).notes[0] == DIFFERENCES
    stop = observed(make(unsafe="stop"), np.array([4.0, 0, 0, 0, 0, 0]), HOME).judge(chunk_to(-200.0, 4))
    assert stop.outcome == "cut"
    assert stop.safe_until == 0.0
    speed = np.radians(-4.0) * FPS
    state = (np.zeros(5), np.array([speed, 0, 0, 0, 0]))
    target = np.radians(chunk_to(-200.0, 4)[0, :, :5])
    verdict = gate.check(target, times=np.arange(1, 5) / FPS, state=state)
    np.testing.assert_allclose(
        np.radians(stop.actions[0, :, :5]), verdict.positions_at(np.arange(1, 5) / FPS), atol=1e-9
    )
    late = make(unsafe="stop")
    late.observe(HOME)
    late._clock.now += 1.0  # type: ignore[attr-defined]
    assert observed(late, HOME).judge(chunk_to(0.0, 1)).notes[0] == FIRST


def test_a_single_action_starts_at_the_last_command(make: Make) -> None:
    actions = observed(make(tracking=0.1), HOME)
    actions.judge(chunk_to(3.0, 1)[:, 0])
    assert COMMAND in observed(actions, HOME).judge(chunk_to(4.0, 1)[:, 0]).notes  # 3 degrees are 0.05 rad
    assert COMMAND not in observed(actions, HOME - 9.0).judge(chunk_to(4.0, 1)[:, 0]).notes
    strict = observed(make(tracking=0.0), HOME)
    strict.judge(chunk_to(3.0, 1)[:, 0])
    assert COMMAND not in observed(strict, HOME).judge(chunk_to(4.0, 1)[:, 0]).notes


def test_joints_a_little_beyond_their_limits(make: Make, gate: Gate) -> None:
    upper = np.degrees(gate.robot.upper[0])
    near = observed(make(), HOME + np.array([upper + 1.0, 0, 0, 0, 0, 0])).judge(chunk_to(upper - 2, 5, upper))
    assert near.outcome == "safe"
    assert BEYOND in near.notes
    state = HOME + np.array([upper + 2.0, 0, 0, 0, 0, 0])
    far = observed(make(), state).judge(chunk_to(upper - 2, 5, upper))
    assert (far.outcome, far.proven) == ("held", False)
    assert "state of joint 'shoulder_pan' must be in" in str(far.reason)
    np.testing.assert_allclose(far.actions[0, :, :5], np.tile(state[:5], (5, 1)))


@pytest.mark.parametrize("unsafe", ["slow", "stop"])
@pytest.mark.parametrize("rest", ["drop", "retime"])
def test_rows_that_are_called_proven_are_free_and_within_limits(unsafe: str, rest: str, make: Make, gate: Gate) -> None:
    """Random motions of an arm that moves already; among them each outcome."""
    rng, robot = np.random.default_rng(3), gate.robot
    seen = set[str]()
    for count in rng.choice([1, 3, 10], size=25).tolist():
        q = rng.uniform(robot.lower, robot.upper) * [0.3, 0.9, 0.8, 0.9, 0.9]
        speed = rng.normal(size=5) * rng.choice([0.0, 1.0, 3.0])
        steps = np.cumsum(rng.normal(size=(count, 5)), axis=0) * rng.choice([0.02, 0.2])
        states = np.degrees([q - speed / FPS, q])
        chunk = np.pad(np.degrees(q + steps), ((0, 0), (0, 1)))[None]
        found = observed(make(unsafe=unsafe, rest=rest), *np.pad(states, ((0, 0), (0, 1)))).judge(chunk)
        seen.add(found.outcome)
        assert found.proven == (found.outcome != "held")
        if found.proven:
            path = lines(found, np.append(states[1], 0.0), fine=60)
            assert_free(gate, path)
            assert np.abs(np.diff(path, axis=0)).max() * 60 * FPS <= 10.0 * (1 + 1e-5)
            assert ((path[1:] >= robot.lower - 1e-6) & (path[1:] <= robot.upper + 1e-6)).all()
    assert seen >= {"safe", "cut"} | ({"slowed"} if unsafe == "slow" else {"held"})


def test_an_arm_that_was_moved_back_within_its_limits_goes_on(make: Make, gate: Gate) -> None:
    """What was held beyond them is no command to start from."""
    upper = np.degrees(gate.robot.upper[0])
    actions = observed(make(), HOME + np.array([upper + 2.0, 0, 0, 0, 0, 0]))
    assert actions.judge(chunk_to(upper - 2, 1)[:, 0]).outcome == "held"
    found = observed(actions, HOME + np.array([upper - 1.0, 0, 0, 0, 0, 0])).judge(chunk_to(upper - 2, 1)[:, 0])
    assert found.outcome == "safe"


def test_the_last_proven_stop_goes_on_if_the_gate_does_not_answer(make: Make, gate: Gate) -> None:
    actions, where = observed(make(unsafe="stop"), HOME), [0.0]
    for pan in (-4.0, -8.0, -12.0):
        where.append(actions.judge(chunk_to(pan, 1)[:, 0]).actions[0, 0])
        actions.observe(HOME + np.array([where[-1], 0, 0, 0, 0, 0]))
    rows = [actions.judge(np.full((1, 6), np.nan))]
    for _ in range(20):
        actions.observe(HOME + np.array([rows[-1].actions[0, 0], 0, 0, 0, 0, 0]))
        rows.append(actions.judge(np.full((1, 6), np.nan)))
    pans = np.array([where[-1], *(row.actions[0, 0] for row in rows)])
    assert (rows[0].outcome, rows[0].proven, LAST in rows[0].notes) == ("cut", False, True)
    steps = -np.diff(pans)
    assert (np.diff(steps) <= 1e-9).all(), "it brakes"
    assert 2.0 < steps[0] < 4.0
    assert abs(steps[-1]) < 1e-9
    assert_free(gate, np.radians(np.outer(np.linspace(pans[0], pans[-1], 200), [1, 0, 0, 0, 0])))


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e12])
def test_numbers_that_are_none_hold_the_robot(bad: float, make: Make) -> None:
    chunk = chunk_to(20.0)
    chunk[0, 7, 2] = bad
    actions = observed(make(), HOME + 1.0)
    found = actions.judge(chunk)
    assert (found.outcome, found.proven) == ("held", False)
    np.testing.assert_allclose(found.actions[0, :, :5], 1.0)
    assert observed(actions, HOME).judge(chunk_to(20.0)).outcome == "safe", "the next chunk counts again"


def test_a_start_in_contact_holds_and_says_so(make: Make) -> None:
    touching = np.array([-80.0, 0, 0, 0, 0, 0])
    found = observed(make(), touching).judge(chunk_to(-70.0, 5, -80.0))
    assert found.outcome == "held"
    assert "no stop is proven" in str(found.reason)


def test_shapes_and_order_are_refused_in_a_sentence(make: Make) -> None:
    actions = make()
    with pytest.raises(StateError, match=r"observation\.state must come before actions"):
        actions.judge(np.zeros((1, 6)))
    actions.observe(HOME)
    for shape in ((2, 6), (2, 5, 6)):
        with pytest.raises(ArrayError, match="actions must be those of one robot, got 2"):
            actions.judge(np.zeros(shape))
    for shape in ((6,), (1, 5), (1, 5, 7), (1, 0, 6), (1, 1, 1, 6)):
        with pytest.raises(ArrayError, match="actions must have shape"):
            actions.judge(np.zeros(shape))
    with pytest.raises(ArrayError, match=r"observation\.state"):
        actions.observe(np.zeros(5))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"unsafe": "halt"}, "unsafe must be one of slow, stop"),
        ({"rest": "keep"}, "rest must be one of drop, retime"),
        ({"fps": 0.0}, "fps must be at least 0.1"),
        ({"tracking": -1.0}, "tracking must be at least 0"),
        ({"state_tolerance": np.nan}, "state_tolerance must be at least 0"),
    ],
)
def test_options_are_checked(options: dict, words: str, gate: Gate) -> None:
    with pytest.raises(OptionError, match=words):
        ActionFilter(gate, NAMES, **options)


def test_counts_and_reasons_and_one_line_in_the_log_for_each_change(
    make: Make, caplog: pytest.LogCaptureFixture
) -> None:
    actions = make(unsafe="stop")
    with caplog.at_level(logging.INFO, "planner.lerobot"):
        for pan in (20.0, -80.0, -80.0, 20.0):
            observed(actions, HOME).judge(chunk_to(pan))
        actions.reset()
    assert actions.counts == {"safe": 2, "cut": 2}
    assert list(actions.reasons.values()) == [2]
    texts = [record.getMessage() for record in caplog.records]
    assert len(texts) == 3
    assert texts[0].startswith("actions are cut: ")
    assert texts[1] == "actions are safe again"
    assert "'cut': 2" in texts[2]
