"""The methods of remark (implementation), in t."""

from __future__ import annotations

import numpy as np
import pytest

from planner import gabf
from planner.reproduce.random_graphs import draw_graph
from planner.reproduce.textbook import Initial, backward_euler, forward_euler, runge_kutta


@pytest.fixture(scope="module")
def graph():
    return draw_graph(np.random.default_rng(5), 60)


def initial(graph, law) -> Initial:
    return Initial(graph.network, law, 10.0, graph.x_star)


@pytest.mark.parametrize("law", [gabf.SingularityFree(), gabf.PrescribedTime()])
def test_the_right_side_is_that_of_gabf(graph, law) -> None:
    start = initial(graph, law)
    x = np.full(60, 10.0)
    x[graph.source] = 0.0
    for t in (0.0, 1.7, 3.99):
        u = start.problem.unpack(start.slope(t, start.y0))
        assert np.allclose(u, gabf.right_side(graph.network, law)(t, x), rtol=1e-12)
    assert start.gain(4.0) == start.gain(5.0) == 0.0


@pytest.mark.parametrize(
    ("method", "order"),
    [(lambda run, n: forward_euler(run, n), 1), (lambda run, n: backward_euler(run, n), 1)],
)
def test_both_euler_methods_are_of_first_order(graph, method, order) -> None:
    start = initial(graph, gabf.PrescribedTime())
    # the first law at half time, where all is smooth
    at = 2.0
    exact = runge_kutta(start, at, rtol=1e-10).last
    errors = [abs(method(start, n).until(at) - exact) for n in (200, 400, 800)]
    ratios = np.array(errors[:-1]) / errors[1:]
    assert np.all(np.abs(np.log2(ratios) - order) < 0.25)


def test_forward_euler_leaves_x_star_before_the_deadline_and_backward_euler_stays(graph) -> None:
    start = initial(graph, gabf.SingularityFree())
    explicit, implicit = forward_euler(start, 2000), backward_euler(start, 500)
    assert explicit.best < 1e-2
    assert explicit.last > 1.0
    assert implicit.last < 1e-9


def test_runge_kutta_says_whether_it_arrived(graph) -> None:
    start = initial(graph, gabf.SingularityFree())
    short = runge_kutta(start, 1.0)
    assert short.reached
    assert short.message == ""
    assert short.t[-1] == 1.0
    assert short.until(0.5) >= short.until(1.0)


def test_overflow_counts_as_an_infinite_error(graph) -> None:
    start = initial(graph, gabf.SingularityFree(m=(15, 1)))
    run = forward_euler(start, 20)
    assert run.last == np.inf
