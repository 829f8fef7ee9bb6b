import numpy as np
import pytest

from planner import gabf
from planner.base.errors import OptionError

from .networks import AtTimes, from_arcs, scattered, solve

NET = scattered(50, seed=1)


def test_nothing_is_kept_unless_asked():
    assert solve(NET).history is None


def test_every_step_keeps_start_and_end():
    result = solve(NET, save=gabf.EverySteps(1))
    saved = result.history
    assert len(saved.tau) == result.steps + 1
    assert np.array_equal(saved.x[0], result.x0)
    assert np.array_equal(saved.x[-1], result.x)
    thin = solve(NET, save=gabf.EverySteps(4)).history
    assert len(thin.tau) == (result.steps + 3) // 4 + 1
    assert np.array_equal(thin.x[1], saved.x[4])
    assert np.array_equal(thin.x[-1], result.x)


def test_chosen_times_are_hit_exactly_and_reach_past_the_deadline():
    t = np.array([0.0, 0.1, 1.0, 3.9, 4.0, 7.0])
    for law in (gabf.SingularityFree(), gabf.PrescribedTime(), gabf.Nominal()):
        result = solve(NET, law, save=AtTimes(t))
        saved = result.history
        assert np.array_equal(saved.t, t)
        assert np.array_equal(saved.tau, law.clock.tau(t))
        assert np.array_equal(saved.x[0], result.x0)
    saved = solve(NET, save=AtTimes(t)).history
    assert np.array_equal(saved.x[-1], gabf.oracle(NET))
    assert (saved.u[-2:] == 0).all()


def test_asking_for_times_does_not_change_where_the_run_ends():
    assert np.array_equal(solve(NET, save=AtTimes([0.123, 0.5])).x, solve(NET).x)


def test_a_run_cut_short_says_nothing_about_later_times():
    saved = solve(NET, save=AtTimes([0.0, 0.1, 3.9, 5.0]), until_tau=5.0).history
    assert saved.t.tolist() == [0.0, 0.1]
    assert saved.x.shape == saved.u.shape == (2, NET.n_nodes)
    empty = solve(NET, save=AtTimes([3.9]), until_tau=5.0).history
    assert empty.x.shape == (0, NET.n_nodes)


def test_unreachable_nodes_are_infinite_and_have_no_input():
    net = from_arcs(3, [(1, 0, 1.0)])
    saved = solve(net, save=gabf.EverySteps(1)).history
    assert np.isinf(saved.x[:, 2]).all()
    assert (saved.u[:, [0, 2]] == 0).all()
    assert saved.u[0, 1] < 0


@pytest.mark.parametrize("t", [[1.0, 0.5], [-1.0], [np.nan], [[1.0]], [0.5, 0.5]])
def test_times_must_ascend(t):
    with pytest.raises(OptionError, match="ascending"):
        AtTimes(t)


def test_k_must_be_positive():
    with pytest.raises(OptionError, match="at least 1"):
        gabf.EverySteps(0)
