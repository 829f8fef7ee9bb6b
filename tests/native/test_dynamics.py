"""Compiled flows and parent values against SciPy's integrators, Python's own powers and NumPy's minima."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from planner.native.compiled import (
    BRAKE_THEN_SINK,
    SINK_THEN_BRAKE,
    STRANG,
    NativeArcs,
    NativeFlow,
    hops_to_source,
    set_threads,
)

EXPONENTS = [(2 / 5, 2 / 7), (8 / 9, 4.0), (2 / 11, 8 / 7), (98 / 99, 998.0), (2e-6, 2e-6), (0.4, 2e-6)]


def sunk(beta1: float, below: float, s: float, dtau: float) -> float:
    return max(s**below - below * beta1 * dtau, 0.0) ** (1 / below)


def braked(beta2: float, above: float, s: float, dtau: float) -> float:
    """s (1 + above beta2 dtau s^above)^(-1/above), by logarithms where the power overflows."""
    log_growth = math.log(above * beta2 * dtau) + above * math.log(s)
    return s * math.exp(-np.logaddexp(0.0, log_growth) / above)


@pytest.mark.parametrize(("below", "above"), EXPONENTS)
@pytest.mark.parametrize("dtau", [1e-9, 1e-3, 0.3, 2.0])
def test_each_order_is_its_two_exact_flows_one_after_the_other(below, above, dtau):
    beta1, beta2 = 0.7, 1.3
    flow = NativeFlow(beta1, beta2, below, above)
    s = np.exp(np.random.default_rng(0).uniform(-25, 8, 200))
    exact = {STRANG: [], BRAKE_THEN_SINK: [], SINK_THEN_BRAKE: []}
    for size in s:
        half = sunk(beta1, below, size, 0.5 * dtau)
        exact[STRANG].append(sunk(beta1, below, braked(beta2, above, half, dtau), 0.5 * dtau) if half else 0.0)
        exact[BRAKE_THEN_SINK].append(sunk(beta1, below, braked(beta2, above, size, dtau), dtau))
        whole = sunk(beta1, below, size, dtau)
        exact[SINK_THEN_BRAKE].append(braked(beta2, above, whole, dtau) if whole else 0.0)
    lost = 1e-13 if below > 1e-3 else 1e-9  # roots of order 1e6 lose digits here, not there
    for order, expected in exact.items():
        assert np.abs(flow.moved(order, s, dtau) - expected).max() <= lost * s.max()
        assert (np.abs(flow.moved(order, s, dtau) - expected) <= lost * s).all()
        assert np.array_equal(flow.moved(order, -s, dtau), -flow.moved(order, s, dtau))


def test_strang_follows_the_equation_in_second_order():
    flow, s = NativeFlow(1.0, 1.0, 2 / 5, 2 / 7), np.array([0.3, 1.0, 20.0])
    exact = solve_ivp(lambda _, s: -(s**0.6) - s ** (9 / 7), (0, 0.4), s, rtol=1e-11, atol=1e-13).y[:, -1]
    errors = []
    for steps in (20, 40):
        y = s
        for _ in range(steps):
            y = flow.moved(STRANG, y, 0.4 / steps)
        errors.append(np.abs(y - exact).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize("seed", range(3))
def test_hops_are_scipys(seed):
    rng = np.random.default_rng(seed)
    counts = rng.integers(0, 4, 80)
    indptr, heads, sources = np.append(0, np.cumsum(counts)), rng.integers(0, 80, counts.sum()), np.array([3, 71])
    far = dijkstra(csr_matrix((np.ones(heads.size), heads, indptr), shape=(80, 80)), unweighted=True)
    fewest = far[:, sources].min(axis=1)
    assert np.isinf(fewest).any()
    assert fewest[np.isfinite(fewest)].max() > 3
    assert np.array_equal(hops_to_source(indptr, heads, sources), np.where(np.isfinite(fewest), fewest, -1))


def random_arcs(rng: np.random.Generator, rows: int, sloped: bool):
    counts = rng.integers(1, 9, rows)
    heads, offset = rng.integers(0, rows + 3, counts.sum()), rng.uniform(0.1, 1.0, counts.sum())
    slope = rng.uniform(0.2, 2.0, counts.sum()) if sloped else None
    return np.cumsum(counts) - counts, heads, slope, offset


@pytest.mark.parametrize("sloped", [False, True])
def test_parent_values_are_minima(sloped):
    rng = np.random.default_rng(1)
    starts, heads, slope, offset = random_arcs(rng, 400, sloped)
    y = rng.normal(size=403)
    values = np.minimum.reduceat((1.0 if slope is None else slope) * y[heads] + offset, starts)
    arcs = NativeArcs(starts, heads, slope, offset)
    assert np.array_equal(arcs.parent_values(None, y), values)
    some = np.array([399, 0, 17])
    assert np.array_equal(arcs.parent_values(some, y), values[some])


@pytest.mark.parametrize("rows", [None, "some"])
def test_a_step_is_made_of_its_parts(rows):
    rng = np.random.default_rng(2)
    flow, n, dtau, size = NativeFlow(1.0, 1.0, 2 / 5, 2 / 7), 700, 0.2, 0.3
    y, m, mid = rng.normal(size=n + 2), rng.normal(size=n), rng.normal(size=n)
    m[::5] = y[:n:5]
    index = np.arange(n) if rows is None else np.sort(rng.choice(n, 300, replace=False))
    chosen = None if rows is None else index
    xhat, mid = y[:n] - m, mid[index]
    following = y.copy()
    flow.sketch(chosen, y, xhat, dtau, following)
    expected = y.copy()
    expected[index] = m[index] + flow.moved(BRAKE_THEN_SINK, xhat[index], dtau)
    assert np.allclose(following, expected, rtol=1e-14, atol=1e-15)
    share = flow.advance(chosen, mid, y, xhat, dtau, size, following)
    s = y[:n][index] - mid
    left = flow.moved(STRANG, s, dtau)
    expected[index] = mid + left
    assert np.array_equal(following, expected)
    off = np.abs((mid - m[index]) * (s - left) / s) / (size + np.abs(xhat[index]))
    assert share == pytest.approx(off.max(), rel=1e-12)


def test_the_same_bits_on_any_number_of_threads():
    rng = np.random.default_rng(3)
    n = 30_011
    flow, arcs = NativeFlow(1.0, 1.0, 2 / 5, 2 / 7), NativeArcs(*random_arcs(rng, n, True))
    y, xhat = rng.normal(size=n + 3), rng.normal(size=n)
    answers = []
    for count in (1, 2, 7, 0):
        set_threads(count)
        following = y.copy()
        m = arcs.parent_values(None, y)
        share = flow.advance(None, m, y, xhat, 0.1, 1.0, following)
        answers.append((m.tobytes(), share, following.tobytes(), flow.moved(STRANG, y, 0.1).tobytes()))
    assert answers[0] == answers[1] == answers[2]
