"""Parabolic ramps: from state to state in the time that is given, within limits, joined without a jump."""

import numpy as np
import pytest

from planner.native.compiled import ramp_quickest

V, A = np.full(3, 2.0), np.array([5.0, 3.0, 8.0])
DURATIONS = np.linspace(0.1, 12.0, 200)


@pytest.mark.parametrize("seed", range(20))
def test_they_join_two_states_within_limits(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(2, 3))
    v = rng.uniform(-2.0, 2.0, size=(2, 3))
    pieces = ramp_quickest((q[0], v[0]), (q[1], v[1]), DURATIONS, V, A)
    assert len(pieces)
    end, slope, late = pieces.sum(axis=1), pieces[:, 1], pieces[:, 1] + 2 * pieces[:, 2]
    seconds = _durations(pieces, v[0])
    np.testing.assert_allclose(pieces[0, 0], q[0])
    np.testing.assert_allclose(end[-1], q[1], atol=1e-12)
    np.testing.assert_allclose(end[:-1], pieces[1:, 0], atol=1e-12)
    np.testing.assert_allclose((late / seconds)[-1], v[1], atol=1e-9)
    assert np.abs(DURATIONS - seconds.sum()).min() < 1e-9
    assert (np.abs(np.concatenate([slope, late]) / np.tile(seconds, (2, 1))) <= V * (1 + 1e-9)).all()
    assert (2 * np.abs(pieces[:, 2]) / seconds**2 <= A * (1 + 1e-9)).all()


def _durations(pieces: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Seconds (m, 1) of each piece, from the velocity at its beginning."""
    found = []
    for _, slope, bend in pieces:
        joint = int(np.abs(velocity).argmax())
        found.append(slope[joint] / velocity[joint])
        velocity = (slope + 2 * bend) / found[-1]
    return np.array(found)[:, None]


def test_from_rest_to_rest_it_takes_as_long_as_a_trapezoid() -> None:
    """Of one joint: 2 sqrt(d / a), or where it cruises d / v + v / a; the next of the durations that are tried."""
    still = np.zeros(1)
    for distance in (0.3, 3.0):
        a, v = 5.0, 2.0
        want = 2 * np.sqrt(distance / a) if distance < v * v / a else distance / v + v / a
        tried = np.array([0.99 * want, 1.001 * want, 1.2 * want])
        pieces = ramp_quickest((still, still), (still + distance, still), tried, np.array([v]), np.array([a]))
        assert len(pieces)
        speed_up = pieces[0, 2, 0]  # a t²/2
        assert speed_up == pytest.approx(0.5 * a * _rise(distance, v, a) ** 2, rel=0.02)
        none = ramp_quickest((still, still), (still + distance, still), tried[:1], np.array([v]), np.array([a]))
        assert not len(none)


def _rise(distance: float, v: float, a: float) -> float:
    return min(np.sqrt(distance / a), v / a)
