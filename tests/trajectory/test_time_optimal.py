"""The quickest motion along a curve."""

import itertools
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from planner.trajectory.curve import Curve, duration_of, fastest_phases, round_corners
from tests.trajectory.test_timing import zigzag


class Phase(NamedTuple):
    """A row of the phases of a motion."""

    piece: int
    s: float
    speed: float
    acceleration: float
    duration: float


def phases_of(curve: Curve, v: np.ndarray, a: np.ndarray) -> list[Phase]:
    return [Phase(int(piece), *row) for piece, *row in fastest_phases(curve, v, a).tolist()]


def test_the_phases_integrate_to_the_curve() -> None:
    """The law against an integrator that knows only the accelerations of the parameter."""
    path = zigzag(4)
    curve = round_corners(path, np.array([1.0, 0.3, 0.0, 0.7, 1.0]))
    v, a = np.full(7, 2.0), np.full(7, 5.0)
    phases = phases_of(curve, v, a)
    for phase in phases:
        run = solve_ivp(
            lambda t, y, u=phase.acceleration: [y[1], u],
            (0.0, phase.duration),
            [phase.s, phase.speed],
            rtol=1e-10,
            atol=1e-12,
            dense_output=True,
        )
        s, speed = run.y
        _, c1, c2 = curve.coefficients[phase.piece]
        slope, bend = c1 + 2 * s[:, None] * c2, 2 * c2
        assert (np.abs(slope * speed[:, None]) <= v * (1 + 1e-9)).all()
        assert (np.abs(slope * phase.acceleration + bend * speed[:, None] ** 2) <= a * (1 + 1e-9)).all()
    for before, after in itertools.pairwise(phases):
        assert _joint_velocity(curve, before, before.duration) == pytest.approx(
            _joint_velocity(curve, after, 0.0), abs=1e-7
        )
    assert _joint_velocity(curve, phases[-1], phases[-1].duration) == pytest.approx(np.zeros(7), abs=1e-7)


def _joint_velocity(curve: Curve, phase: Phase, t: float) -> np.ndarray:
    s = phase.s + phase.speed * t + 0.5 * phase.acceleration * t**2
    _, c1, c2 = curve.coefficients[phase.piece]
    return (c1 + 2 * s * c2) * (phase.speed + phase.acceleration * t)


@pytest.mark.parametrize("seed", range(20))
def test_velocities_hold_all_along_intervals_on_which_joints_turn_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    path = rng.normal(size=(3, 4)) * 10.0 ** rng.uniform(-2.0, 1.0, size=(1, 4))
    curve, v, a = round_corners(path, np.ones(1)), 10.0 ** rng.uniform(-1.0, 1.0, 4), np.full(4, 1e3)
    largest = 0.0
    for phase in phases_of(curve, v, a):
        t = np.linspace(0.0, phase.duration, 50)[:, None]
        s = phase.s + (phase.speed + 0.5 * phase.acceleration * t) * t
        _, c1, c2 = curve.coefficients[phase.piece]
        share = np.abs((c1 + 2.0 * s * c2) * (phase.speed + phase.acceleration * t)) / v
        largest = max(largest, float(share.max()))
    assert 0.99 < largest <= 1.0 + 1e-9


def test_no_motion_on_a_finer_grid_of_speeds_is_quicker() -> None:
    """Dynamic programming over x on a fine grid, with other code, comes no lower and close."""
    curve = round_corners(zigzag(5, corners=1, dof=3), np.ones(1))
    v, a = np.full(3, 2.0), np.full(3, 5.0)
    found = duration_of(fastest_phases(curve, v, a))
    assert found == pytest.approx(_by_forward_backward(curve, v, a), rel=0.02)


def _by_forward_backward(curve: Curve, v: np.ndarray, a: np.ndarray, n: int = 800) -> float:
    """Maximum velocity curve and the two passes below it (Bobrow 1985), by arc length in small steps."""
    s = np.linspace(0.0, 1.0, n)
    q = np.concatenate([c0 + s[:, None] * c1 + s[:, None] ** 2 * c2 for c0, c1, c2 in curve.coefficients])
    q = q[np.concatenate([[True], np.linalg.norm(np.diff(q, axis=0), axis=1) > 1e-12])]
    h = np.linalg.norm(np.diff(q, axis=0), axis=1)
    tangent = np.diff(q, axis=0) / h[:, None]
    bend = np.diff(tangent, axis=0) / (0.5 * (h[1:] + h[:-1]))[:, None]
    most = np.minimum(((v / np.abs(tangent[1:])).min(axis=1)) ** 2, (a / np.maximum(np.abs(bend), 1e-9)).min(axis=1))
    x = np.concatenate([[0.0], most, [0.0]])
    for order in (range(1, len(x)), range(len(x) - 2, -1, -1)):
        step = 1 if order.step > 0 else -1
        for k in order:
            other = k - step
            row = min(max(min(k, other), 0), len(tangent) - 1)
            curved = bend[min(row, len(bend) - 1)] * x[other]
            slack = a - np.abs(curved)
            u = (np.maximum(slack, 0.0) / np.maximum(np.abs(tangent[row]), 1e-12)).min()
            x[k] = min(x[k], x[other] + 2 * u * h[row])
    return float((2 * h / (np.sqrt(x[:-1]) + np.sqrt(x[1:]))).sum())
