"""What section 4.2 says of its manipulator, sentence by sentence, against what was measured.

The paper calls the path of beta = 0 and 0.3 red and that of 0.5, 0.7 and 1 blue. Where ours do not fall into these two
groups, red is the path of beta = 0 and blue that of beta = 1. A reading in square brackets is ours: the sentence has
no number of its own.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from planner.problem.request import PAPER_EDGES, PAPER_NODES
from planner.reproduce.manipulator.case import BETAS, RRT, SHORTENED, MeasuredPath, SeedStudy, label_of
from planner.reproduce.manipulator.geometry import mean_distance, shared_segments
from planner.reproduce.report import Verdict, spread, tally

RED, BLUE = BETAS[:2], BETAS[2:]
PAPER_COSTS = {**dict.fromkeys(RED, (0.0331, 47.4037)), **dict.fromkeys(BLUE, (1.1038, 46.2546))}
"""The printed accumulated (manipulability, distance) costs by beta."""

SLIGHTLY = 1.1
SIGNIFICANTLY = 0.5
ZIGZAG = 2
EXACT = 1e-9


def manipulator_verdicts(cases: Sequence[SeedStudy], T_p: float) -> tuple[Verdict, ...]:
    """Every sentence on the cases that have paths, in the paper's order, and what we add, marked "(ours)"."""
    whole = [case for case in cases if case.ways]
    return (
        *_network_verdicts(cases, T_p),
        *_path_verdicts(whole),
        *_rrt_verdicts(whole),
        *_weight_verdicts(whole),
        *_cost_verdicts(whole),
        *_shape_verdicts(whole),
        *_zigzag_verdicts(whole),
        *_objective_verdicts(whole),
    )


def groups_text(groups: Sequence[Sequence[float]]) -> str:
    """The betas that share a path, as "0 0.3 | 0.5 0.7 1"."""
    return " | ".join(" ".join(f"{beta:g}" for beta in group) for group in groups)


def _network_verdicts(cases: Sequence[SeedStudy], T_p: float) -> Iterator[Verdict]:
    zetas, ls = ([getattr(f, name) for case in cases for f in case.fields] for name in ("zeta", "L"))
    yield tally(
        "The kernel satisfies progressiveness and strict monotonicity as required.",
        (all(f.zeta > 0 and np.isfinite(f.L) for f in case.fields) for case in cases),
        f"smallest zeta {min(zetas, default=np.nan):.3g} and L = {max(ls, default=np.nan):.3g} over all beta; it "
        "holds at beta = 0 because we normalise omega into [0.01, 1]: a node of cost 0 would break it there",
    )
    sizes = Counter((len(case.roadmap.nodes), len(case.roadmap.edges)) for case in cases)
    yield tally(
        f"We generate a network consisting of {PAPER_NODES} nodes and {PAPER_EDGES} edges, using RRT.",
        ((len(c.roadmap.nodes), len(c.roadmap.edges)) == (PAPER_NODES, PAPER_EDGES) for c in cases),
        "; ".join(f"{nodes} nodes and {edges} edges in {count}" for (nodes, edges), count in sizes.items())
        + "; an RRT alone is a tree with one path between two nodes, so neighbours are linked as well",
    )
    yield tally(
        "(ours) Start and goal are connected within the roadmap.",
        (bool(case.ways) for case in cases),
        "what follows is about the roadmaps in which they are",
    )
    fields = [f for case in cases for f in case.fields]
    times = [np.inf if f.settling_time is None else f.settling_time for f in fields]
    yield tally(
        f"(ours) Every field settles before T_p = {T_p:g} s and equals Dijkstra's, under the singularity-free law.",
        (all((f.settling_time or np.inf) < T_p and f.error <= EXACT for f in case.fields) for case in cases),
        f"settling time {spread(times)} s, largest relative error {max((f.error for f in fields), default=np.nan):.1g}",
    )


def _path_verdicts(cases: Sequence[SeedStudy]) -> Iterator[Verdict]:
    seen = Counter(groups_text(case.groups) for case in cases)
    grouping = "; ".join(f"{text} in {count}" for text, count in seen.most_common())
    yield tally(
        "GABF produces the same path for both beta = 0 and beta = 0.3 ...",
        (_one_path(case, RED) for case in cases),
        f"betas that share a path: {grouping}",
    )
    yield tally(
        "... as well as a common path for beta = 0.5, 0.7 and 1.",
        (_one_path(case, BLUE) for case in cases),
        "see above",
    )
    yield tally(
        "Most segments of the three trajectories (red, blue and RRT) differ from each other.",
        (all(shared < 0.5 for shared in _shared(case, RRT)) for case in cases),
        f"largest share of segments in common: {spread(max(_shared(c, RRT)) for c in cases)}; with RRT's path after "
        f"its shortcuts: {spread(max(_shared(c, SHORTENED)) for c in cases)}",
    )


def _rrt_verdicts(cases: Sequence[SeedStudy]) -> Iterator[Verdict]:
    near = {beta: [_to(case, beta, RRT) for case in cases] for beta in BETAS}
    farthest, nearest = (np.max([near[beta] for beta in BLUE], axis=0), np.min([near[beta] for beta in RED], axis=0))
    yield tally(
        "The trajectory generated with beta = 0.5, 0.7 or 1 is closer to that produced by RRT "
        "[blue than red, by the mean distance of the tool paths].",
        (_closer(case, RRT) for case in cases),
        "mean distance in m: "
        + "; ".join(f"beta = {beta:g}: {spread(values, '.2g')}" for beta, values in near.items())
        + f"; each of 0.5, 0.7 and 1 closer than both 0 and 0.3: {int((farthest < nearest).sum())} of "
        f"{len(cases)}; blue closer to RRT's path after its shortcuts: {sum(_closer(c, SHORTENED) for c in cases)} of "
        f"{len(cases)}",
    )


def _weight_verdicts(cases: Sequence[SeedStudy]) -> Iterator[Verdict]:
    shares = {
        beta: [beta * path.distance_cost / path.total(beta) for path in (case.way(beta) for case in cases)]
        for beta in BETAS
    }
    yield tally(
        "... since in this case the distance cost gradually outweighs the manipulability cost "
        "[beta D > (1 - beta) Omega at 0.5, 0.7 and 1].",
        (all(shares[beta][k] > 0.5 for beta in BLUE) for k in range(len(cases))),
        "share of beta D in the total: "
        + "; ".join(f"beta = {beta:g}: {spread(values, '.2g')}" for beta, values in shares.items())
        + "; by the paper's printed costs it is 0.998 already at beta = 0.3",
    )
    rrt, (red, blue) = [case.ways[RRT] for case in cases], _ends(cases)
    yield tally(
        "The RRT algorithm only considers the distance cost [its path costs less distance and more manipulability than "
        "that of beta = 0].",
        (
            a.distance_cost < b.distance_cost and a.manipulability_cost > b.manipulability_cost
            for a, b in zip(rrt, red, strict=True)
        ),
        "RRT weighs no cost, it takes the first path it finds: D is "
        f"{spread(_ratios(rrt, blue, 'distance_cost'))} times that of beta = 1",
    )


def _cost_verdicts(cases: Sequence[SeedStudy]) -> Iterator[Verdict]:
    red, blue = _ends(cases)
    omega, distance = _ratios(red, blue, "manipulability_cost"), _ratios(red, blue, "distance_cost")
    yield tally(
        "The path of beta = 0 or 0.3 prioritizes manipulability, that of 0.5, 0.7 or 1 emphasizes path length.",
        (_ordered(case) for case in cases),
        "Omega of 0 and 0.3 at most that of 0.5, 0.7 and 1, and D at least",
    )
    yield tally(
        "The red path achieves a significantly lower accumulated manipulability cost (0.0331 versus 1.1038) "
        f"[at most {SIGNIFICANTLY:g} times].",
        (ratio <= SIGNIFICANTLY for ratio in omega),
        f"Omega {spread(w.manipulability_cost for w in red)} versus {spread(w.manipulability_cost for w in blue)}: "
        f"{spread(omega)} times, lower in {sum(ratio < 1 for ratio in omega)}; the paper's 0.030 times over a path of "
        "about the same length needs nodes that cost almost nothing, its normalisation is not given",
    )
    yield tally(
        "... at the expense of a slightly larger accumulated distance cost (47.4037 versus 46.2546) "
        f"[larger, at most {SLIGHTLY:g} times].",
        (1.0 < ratio <= SLIGHTLY for ratio in distance),
        f"D {spread(w.distance_cost for w in red)} versus {spread(w.distance_cost for w in blue)}: {spread(distance)} "
        "times; the paper's is 1.025 times",
    )


def _shape_verdicts(cases: Sequence[SeedStudy]) -> Iterator[Verdict]:
    red, blue = _ends(cases)
    length, turn = _ratios(red, blue, "workspace_length"), _ratios(red, blue, "turning")
    yield tally(
        f"The red path does not appear significantly longer than the blue path [tool path at most {SLIGHTLY:g} times].",
        (ratio <= SLIGHTLY for ratio in length),
        f"tool path {spread(w.workspace_length for w in red)} m versus {spread(w.workspace_length for w in blue)} m: "
        f"{spread(length)} times",
    )
    yield tally(
        "It exhibits larger curvature in the three-dimensional workspace [total curvature of the tool path].",
        (ratio > 1.0 for ratio in turn),
        f"{spread(w.turning for w in red)} rad versus {spread(w.turning for w in blue)} rad",
    )
    yield tally(
        "... resulting in a longer actual travel distance.",
        (ratio > 1.0 for ratio in length),
        f"tool path {spread(length)} times as long; joint path {spread(_ratios(red, blue, 'joint_length'))} times",
    )


def _zigzag_verdicts(cases: Sequence[SeedStudy]) -> Iterator[Verdict]:
    named = {"blue": label_of(1.0), "red": label_of(0.0), RRT: RRT, SHORTENED: SHORTENED}
    sharp = {name: [case.ways[label].sharp_turns for case in cases] for name, label in named.items()}
    yield tally(
        f"The blue path exhibits a zigzag pattern [the tool turns by more than 45 degrees at {ZIGZAG} or more "
        "waypoints].",
        (count >= ZIGZAG for count in sharp["blue"]),
        "such waypoints: "
        + "; ".join(f"{name} {spread(counts)}" for name, counts in sharp.items())
        + f"; blue is RRTConnect's path after its shortcuts in {sum(_shared(c, SHORTENED)[2] == 1.0 for c in cases)}",
    )
    yield tally(
        "This is mainly due to the non-uniform sampling property of the RRT algorithm [shortcuts, which need not "
        "follow the sampled nodes, lessen RRT's own total curvature].",
        (case.ways[SHORTENED].turning < case.ways[RRT].turning for case in cases),
        f"{spread(case.ways[RRT].turning for case in cases)} rad before, "
        f"{spread(case.ways[SHORTENED].turning for case in cases)} rad after",
    )


def _objective_verdicts(cases: Sequence[SeedStudy]) -> Iterator[Verdict]:
    sentence = (
        "For beta = 0 or 0.3 the total cost of the red path is lower than that of the blue path, the opposite for "
    )
    yield tally(
        sentence + "0.5, 0.7 and 1.",
        (_consistent(lambda path, beta: path.total(beta), *pair) for pair in zip(*_ends(cases), strict=True)),
        f"the two costs are equal at beta = {spread(b for b in map(_crossing, *_ends(cases)) if b is not None)}",
    )
    red, blue = PAPER_COSTS[0.0], PAPER_COSTS[1.0]
    yield tally(
        sentence + "0.5, 0.7 and 1, on the costs that the paper prints.",
        [_consistent(lambda cost, beta: (1 - beta) * cost[0] + beta * cost[1], red, blue)],
        f"the two printed costs are equal at beta = {(blue[0] - red[0]) / (blue[0] - red[0] + red[1] - blue[1]):.4f}",
    )
    touching = [path.contact for case in cases for path in case.ways.values() if path.contact]
    yield tally(
        "(ours) Every path is free of collision when sampled every millimetre of motion.",
        (all(path.contact is None for path in case.ways.values()) for case in cases),
        f"{sum(len(case.ways) for case in cases)} paths" + "".join(f"; {contact} touch" for contact in touching),
    )


def _one_path(case: SeedStudy, betas: Sequence[float]) -> bool:
    return any(set(betas) <= set(group) for group in case.groups)


def _shared(case: SeedStudy, rrt: str) -> list[float]:
    red, blue, tree = case.way(0.0).nodes, case.way(1.0).nodes, case.ways[rrt].nodes
    return [shared_segments(red, blue), shared_segments(red, tree), shared_segments(blue, tree)]


def _to(case: SeedStudy, beta: float, rrt: str) -> float:
    return mean_distance(case.way(beta).tool, case.ways[rrt].tool)


def _closer(case: SeedStudy, rrt: str) -> bool:
    return _to(case, 1.0, rrt) < _to(case, 0.0, rrt)


def _ends(cases: Sequence[SeedStudy]) -> tuple[list[MeasuredPath], list[MeasuredPath]]:
    """The red and the blue path of every case."""
    return [case.way(0.0) for case in cases], [case.way(1.0) for case in cases]


def _ratios(red: Sequence[MeasuredPath], blue: Sequence[MeasuredPath], name: str) -> list[float]:
    return [getattr(a, name) / getattr(b, name) for a, b in zip(red, blue, strict=True)]


def _ordered(case: SeedStudy) -> bool:
    return all(
        a.manipulability_cost <= b.manipulability_cost + EXACT and a.distance_cost >= b.distance_cost - EXACT
        for a, b in itertools.product(map(case.way, RED), map(case.way, BLUE))
    )


def _consistent(total: Callable[..., float], red, blue) -> bool:
    lower = all(total(red, beta) < total(blue, beta) for beta in RED)
    return lower and all(total(blue, beta) < total(red, beta) for beta in BLUE)


def _crossing(red: MeasuredPath, blue: MeasuredPath) -> float | None:
    """The beta at which two paths cost the same, None where they are one path."""
    saved, spent = blue.manipulability_cost - red.manipulability_cost, red.distance_cost - blue.distance_cost
    return saved / (saved + spent) if saved + spent > 0 else None
