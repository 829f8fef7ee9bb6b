"""The sentences of section 4.2, and their checks on one roadmap.

A reading in square brackets is ours: the sentence has no number of its own.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from planner.base.arrays import combine_costs
from planner.problem.options import PAPER_EDGES, PAPER_NODES
from planner.problem.request import SweepRequest
from reproduce.manipulator.case import BETAS, BLUE, RED, RRT, SHORTENED, SeedStudy, SolveFacts
from reproduce.manipulator.geometry import mean_distance
from reproduce.report import Claim

T_P = SweepRequest().quality.prescribed_time
SLIGHTLY = 1.1
SIGNIFICANTLY = 0.5
ZIGZAG = 2
EXACT = 1e-9

Costs = Mapping[float, tuple[float, float]]
"""Accumulated (manipulability, distance) costs by beta."""


def _of_fields(quantity: Callable[[SolveFacts], float | None]) -> Callable[[SeedStudy], Iterable[float]]:
    return lambda case: (np.nan if value is None else value for value in map(quantity, case.fields))


def _is_in_time(field: SolveFacts) -> bool:
    return field.settling_time is not None and field.settling_time < T_P and field.error <= EXACT


NETWORK: tuple[Claim[SeedStudy], ...] = (
    Claim(
        "The kernel satisfies progressiveness and strict monotonicity as required.",
        lambda case: all(field.zeta > 0 and np.isfinite(field.L) for field in case.fields),
        "zeta {}, L {}; it holds at beta = 0 because we normalise omega into [0.01, 1]: a node of cost 0 would break "
        "it there",
        (_of_fields(lambda field: field.zeta), _of_fields(lambda field: field.L)),
    ),
    Claim(
        f"We generate a network consisting of {PAPER_NODES} nodes and {PAPER_EDGES} edges, using RRT.",
        lambda case: (len(case.roadmap.nodes), len(case.roadmap.edges)) == (PAPER_NODES, PAPER_EDGES),
        "an RRT alone is a tree with one path between two nodes, so neighbours are linked as well",
    ),
    Claim("(ours) Start and goal are connected within the roadmap.", lambda case: bool(case.ways)),
    Claim(
        f"(ours) Every field settles before T_p = {T_P:g} s and equals Dijkstra's, under the singularity-free law.",
        lambda case: all(map(_is_in_time, case.fields)),
        "settling time {} s, relative error {:.1g}",
        (_of_fields(lambda field: field.settling_time), _of_fields(lambda field: field.error)),
    ),
)


def _is_one_path(case: SeedStudy, betas: Sequence[float]) -> bool:
    return any(set(betas) <= set(group) for group in case.groups)


def _to(case: SeedStudy, beta: float, rrt: str = RRT) -> float:
    return mean_distance(case.way(beta).tool, case.ways[rrt].tool)


def _distance_share(case: SeedStudy, beta: float) -> float:
    path = case.way(beta)
    return beta * path.distance_cost / path.total(beta)


def _is_monotone(case: SeedStudy) -> bool:
    return all(
        a.manipulability_cost <= b.manipulability_cost + EXACT and a.distance_cost >= b.distance_cost - EXACT
        for a, b in itertools.product(map(case.way, RED), map(case.way, BLUE))
    )


def _costs(case: SeedStudy) -> Costs:
    return {beta: (case.way(beta).manipulability_cost, case.way(beta).distance_cost) for beta in BETAS}


def is_consistent(costs: Costs) -> bool:
    """Whether the total cost of red is the lower one at the betas of red, and that of blue at those of blue."""
    red, blue = costs[RED[0]], costs[BLUE[-1]]
    lower = all(combine_costs(beta, *red) < combine_costs(beta, *blue) for beta in RED)
    return lower and all(combine_costs(beta, *blue) < combine_costs(beta, *red) for beta in BLUE)


def crossing(costs: Costs) -> list[float]:
    """The beta at which red and blue cost the same; none where they are one path."""
    red, blue = costs[RED[0]], costs[BLUE[-1]]
    saved, spent = blue[0] - red[0], red[1] - blue[1]
    return [saved / (saved + spent)] if saved + spent > 0 else []


PATHS: tuple[Claim[SeedStudy], ...] = (
    Claim(
        "GABF produces the same path for both beta = 0 and beta = 0.3 ...",
        lambda case: _is_one_path(case, RED),
        "{} different paths",
        (lambda case: len(case.groups),),
    ),
    Claim("... as well as a common path for beta = 0.5, 0.7 and 1.", lambda case: _is_one_path(case, BLUE)),
    Claim(
        "Most segments of the three trajectories (red, blue and RRT) differ from each other.",
        lambda case: case.shared() < 0.5,
        "largest share of segments in common: {}; with RRT's path after its shortcuts: {}",
        (lambda case: case.shared(), lambda case: case.shared(SHORTENED)),
    ),
    Claim(
        "The trajectory generated with beta = 0.5, 0.7 or 1 is closer to that produced by RRT "
        "[blue than red, by the mean distance of the tool paths].",
        lambda case: _to(case, 1.0) < _to(case, 0.0),
        "mean distance of red {:.2g} m, of blue {:.2g} m; from RRT's path after its shortcuts {:.2g} m and {:.2g} m",
        tuple(lambda case, a=beta, b=rrt: _to(case, a, b) for rrt in (RRT, SHORTENED) for beta in (0.0, 1.0)),
    ),
    Claim(
        "... since in this case the distance cost gradually outweighs the manipulability cost "
        "[beta D > (1 - beta) Omega at 0.5, 0.7 and 1].",
        lambda case: all(_distance_share(case, beta) > 0.5 for beta in BLUE),
        "share of beta D in the total: {:.2g} at beta = 0.3, {:.2g} at 0.5, {:.2g} at 0.7; by the paper's printed "
        "costs it is 0.998 already at beta = 0.3",
        tuple(lambda case, beta=beta: _distance_share(case, beta) for beta in BETAS[1:-1]),
    ),
    Claim(
        "The RRT algorithm only considers the distance cost [its path costs less distance and more manipulability than "
        "that of beta = 0].",
        lambda case: (
            case.ways[RRT].distance_cost < case.red.distance_cost
            and case.ways[RRT].manipulability_cost > case.red.manipulability_cost
        ),
        "RRT weighs no cost, it takes the first path it finds: its D is {} times that of beta = 1",
        (lambda case: case.ways[RRT].distance_cost / case.blue.distance_cost,),
    ),
    Claim(
        "The path of beta = 0 or 0.3 prioritizes manipulability, that of 0.5, 0.7 or 1 emphasizes path length.",
        _is_monotone,
        "Omega of 0 and 0.3 at most that of 0.5, 0.7 and 1, and D at least",
    ),
    Claim(
        "The red path achieves a significantly lower accumulated manipulability cost (0.0331 versus 1.1038) "
        f"[at most {SIGNIFICANTLY:g} times].",
        lambda case: case.ratio("manipulability_cost") <= SIGNIFICANTLY,
        "Omega {} versus {}: {} times; the paper's 0.030 times over a path of about the same length needs nodes that "
        "cost almost nothing, its normalisation is not given",
        (
            lambda case: case.red.manipulability_cost,
            lambda case: case.blue.manipulability_cost,
            lambda case: case.ratio("manipulability_cost"),
        ),
    ),
    Claim(
        "... at the expense of a slightly larger accumulated distance cost (47.4037 versus 46.2546) "
        f"[larger, at most {SLIGHTLY:g} times].",
        lambda case: 1.0 < case.ratio("distance_cost") <= SLIGHTLY,
        "D {} versus {}: {} times; the paper's is 1.025 times",
        (
            lambda case: case.red.distance_cost,
            lambda case: case.blue.distance_cost,
            lambda case: case.ratio("distance_cost"),
        ),
    ),
    Claim(
        f"The red path does not appear significantly longer than the blue path [tool path at most {SLIGHTLY:g} times].",
        lambda case: case.ratio("workspace_length") <= SLIGHTLY,
        "tool path {} m versus {} m",
        (lambda case: case.red.workspace_length, lambda case: case.blue.workspace_length),
    ),
    Claim(
        "It exhibits larger curvature in the three-dimensional workspace [total curvature of the tool path].",
        lambda case: case.ratio("turning") > 1.0,
        "{} rad versus {} rad",
        (lambda case: case.red.turning, lambda case: case.blue.turning),
    ),
    Claim(
        "... resulting in a longer actual travel distance.",
        lambda case: case.ratio("workspace_length") > 1.0,
        "tool path {} times as long; joint path {} times",
        (lambda case: case.ratio("workspace_length"), lambda case: case.ratio("joint_length")),
    ),
    Claim(
        f"The blue path exhibits a zigzag pattern [the tool turns by more than 45 degrees at {ZIGZAG} or more "
        "waypoints].",
        lambda case: case.blue.sharp_turns >= ZIGZAG,
        "such waypoints: blue {}, red {}, RRT {}, RRT after its shortcuts {}",
        (
            lambda case: case.blue.sharp_turns,
            lambda case: case.red.sharp_turns,
            lambda case: case.ways[RRT].sharp_turns,
            lambda case: case.ways[SHORTENED].sharp_turns,
        ),
    ),
    Claim(
        "This is mainly due to the non-uniform sampling property of the RRT algorithm [shortcuts, which need not "
        "follow the sampled nodes, lessen RRT's own total curvature].",
        lambda case: case.ways[SHORTENED].turning < case.ways[RRT].turning,
        "{} rad before, {} rad after",
        (lambda case: case.ways[RRT].turning, lambda case: case.ways[SHORTENED].turning),
    ),
    Claim(
        "For beta = 0 or 0.3 the total cost of the red path is lower than that of the blue path, the opposite for 0.5, "
        "0.7 and 1.",
        lambda case: is_consistent(_costs(case)),
        "the two costs are equal at beta = {}",
        (lambda case: crossing(_costs(case)),),
    ),
    Claim(
        "(ours) Every path is free of collision when sampled every millimetre of motion.",
        lambda case: all(path.contact is None for path in case.ways.values()),
    ),
)

PRINTED: tuple[Claim[Costs], ...] = (
    Claim(
        "For beta = 0 or 0.3 the total cost of the red path is lower than that of the blue path, the opposite for 0.5, "
        "0.7 and 1, on the costs that the paper prints.",
        is_consistent,
        "the two costs are equal at beta = {:.4f}",
        (crossing,),
    ),
)
