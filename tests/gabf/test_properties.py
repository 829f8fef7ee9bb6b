"""What must hold for every network, kernel, law and start."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planner import gabf

from .networks import Network, from_arcs, require_paths, solve

LENGTHS = st.one_of(st.integers(1, 4).map(float), st.floats(1e-3, 1e3))
FINE = gabf.Splitting(0.01)


@st.composite
def networks(draw, kernels=("additive", "tradeoff", "integral", "product", "parity", "user")):
    n = draw(st.integers(1, 12))
    linked = draw(st.integers(min(1, n - 1), n - 1))
    tree = [(i, draw(st.integers(0, i - 1)), draw(LENGTHS)) for i in range(1, linked + 1)]
    pairs = st.tuples(st.integers(0, n - 1), st.integers(0, n - 1), LENGTHS)
    extra = draw(st.lists(pairs, max_size=30))
    arcs = tree + [arc for arc in extra if arc[0] != arc[1]]
    sources = sorted({0, *draw(st.sets(st.integers(0, n - 1), max_size=2))})
    kind = draw(st.sampled_from(kernels))
    if kind == "product":
        arcs = [(i, j, 0.05 + 0.9 * w / (1.0 + w)) for i, j, w in arcs]
    values = np.ones(len(sources)) if kind == "parity" else np.zeros(len(sources))
    costs = np.array([draw(st.floats(0.01, 3.0)) for _ in range(max(n, len(arcs)))])
    more = {"node_cost": costs[:n], "arc_cost": costs[: len(arcs)]}
    return from_arcs(n, arcs, sources, source_values=values, kernel=_kernel(draw, kind), **more)


def _kernel(draw, kind):
    beta = draw(st.floats(0.0, 1.0))
    return {
        "additive": gabf.Additive(),
        "tradeoff": gabf.TradeOff(beta),
        "integral": gabf.EdgeIntegral(beta),
        "product": gabf.Multiplicative(),
        "parity": gabf.NodeDependent(),
        "user": gabf.UserKernel(lambda i, a, b: a + b + 0.3 * np.tanh(a) + 0.3),
    }[kind]


@st.composite
def runs(draw):
    """A network with a start inside its kernel's domain, possibly the default one."""
    net = draw(networks())
    if draw(st.booleans()):
        return net, None
    low, high = {gabf.Multiplicative: (-3.0, 0.9), gabf.NodeDependent: (1.0, 60.0)}.get(
        type(net.kernel), (-20.0, 200.0)
    )
    return net, np.array([draw(st.floats(low, high)) for _ in range(net.n_nodes)])


@settings(max_examples=100, deadline=None)
@given(networks(("additive", "tradeoff", "integral", "product")), st.randoms(use_true_random=False))
def test_renumbering_the_nodes_renumbers_the_result(net, random):
    order = list(range(net.n_nodes))
    random.shuffle(order)
    new = np.array(order)
    arcs = np.argsort(new[net.tails], kind="stable")
    renumbered = Network(
        np.concatenate(([0], np.cumsum(np.bincount(new[net.tails], minlength=net.n_nodes)))),
        new[net.indices[arcs]],
        net.weight[arcs],
        new[net.sources],
        source_values=net.source_values,
        node_cost=net.node_cost[np.argsort(new)],
        arc_cost=net.arc_cost[arcs],
        kernel=net.kernel,
    )
    one, two = solve(net), solve(renumbered)
    assert np.array_equal(one.x, two.x[new])
    assert one.steps == two.steps
    assert np.isclose(one.settling_tau, two.settling_tau, rtol=1e-9)


@settings(max_examples=100, deadline=None)
@given(networks())
def test_the_two_oracles_agree(net):
    x, _ = gabf.value_iteration(net, gabf.overestimate(net))
    assert np.array_equal(x, gabf.oracle(net))


@settings(max_examples=100, deadline=None)
@given(runs(), st.integers(0, 10_000))
def test_a_changed_network_is_healed_from_the_old_field(run, pick):
    net, _ = run
    assume(net.n_arcs > 1)
    before = solve(net)
    changed = net.without_arcs([pick % net.n_arcs])
    warm = np.where(np.isfinite(before.x), before.x, 1.0 if not _bounded(net) else 0.0)
    assert np.array_equal(solve(changed, x0=warm).x, gabf.oracle(changed))


POSITIVE = st.floats(0.01, 100)
POWERS = {"p": st.sampled_from([(3, 5), (5, 7), (9, 11), (1, 3)]), "m": st.sampled_from([(9, 7), (15, 7), (3, 1)])}
BETAS = {"beta1": st.floats(0.3, 3), "beta2": st.floats(0.3, 3)}
CLOCK = {"T": POSITIVE, "h": st.floats(0.1, 8), "gamma": st.floats(0.1, 20)}
RATES = (np.tanh, np.sign, np.cbrt, lambda s: s / (1.0 + s * s), lambda s: np.where(s > 0, s, 4.0 * s))
LAWS = st.one_of(
    st.builds(gabf.Nominal, eta=POSITIVE),
    st.builds(gabf.PrescribedTime, **CLOCK),
    st.builds(gabf.FixedTime, **BETAS, **POWERS),
    st.builds(gabf.SingularityFree, **CLOCK, **BETAS, **POWERS),
    st.builds(
        gabf.UserLaw, st.sampled_from(RATES), st.sampled_from([gabf.UniformClock(7.0), gabf.PrescribedClock(T=0.3)])
    ),
)


@settings(max_examples=250, deadline=None)
@given(runs(), LAWS)
def test_every_law_settles_on_dijkstras_field_in_time_and_within_every_proven_bound(run, law):
    net, x0 = run
    result = solve(net, law, None if law.needs_overestimate else x0, FINE, save_every=1)
    x_star = gabf.oracle(net)
    assert result.outcome is gabf.Ending.SETTLED
    assert np.array_equal(result.x, x_star)
    assert result.residual == 0.0
    assert law.prescribed_time is None or result.settling_time <= law.prescribed_time
    require_paths(net, result)
    for certificate in gabf.certify(net, law, result):
        assert certificate.holds or "as printed" in certificate.name, certificate
    finite = np.isfinite(x_star)
    if (result.x0[finite] >= x_star[finite]).all() and not isinstance(law, gabf.UserLaw):  # starts above stay above
        assert (result.history.x[:, finite] >= x_star[finite] - 1e-12 * np.abs(x_star[finite])).all()


def _bounded(net):
    return isinstance(net.kernel, gabf.Multiplicative)
