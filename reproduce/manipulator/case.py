"""One roadmap of section 4.2: the path of every beta on it, and RRTConnect's own path, all measured alike."""

from __future__ import annotations

import itertools
from dataclasses import asdict, dataclass, replace
from functools import lru_cache

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints, combine_costs
from planner.problem.request import SweepRequest
from planner.query.query import Query, make_query
from planner.roadmap.build import build_roadmap
from planner.roadmap.grow import GrowthSettings
from planner.roadmap.measure import measure_edges
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.search.network import PathCost, build_network, path_cost
from planner.trajectory.measure import measure_path, path_contact
from reproduce.manipulator.geometry import kinks, sampled_tool_path, turning

BETAS = (0.0, 0.3, 0.5, 0.7, 1.0)
"""The betas of section 4.2."""

RED, BLUE = BETAS[:2], BETAS[2:]
"""The betas of the paper's red path and of its blue one."""

PAPER_COSTS = {**dict.fromkeys(RED, (0.0331, 47.4037)), **dict.fromkeys(BLUE, (1.1038, 46.2546))}
"""The printed accumulated (manipulability, distance) costs by beta."""

RRT, SHORTENED = "RRT", "RRT, shortened"
"""RRTConnect's path as it is found, and after the shortcuts with which it becomes the roadmap's first path."""

KINK = np.radians(45.0)


def label_of(beta: float) -> str:
    """The name of a beta's path."""
    return f"beta = {beta:g}"


LABELS = (*map(label_of, BETAS), RRT, SHORTENED)


@dataclass(frozen=True, eq=False)
class MeasuredPath:
    """A path and its measures. ``q`` (k, dof) rad; ``tool`` (n, 3) m, evenly spaced; ``kinks`` (k - 2,) rad.

    ``nodes`` (k, dof): the rows of the roadmap, to the last bit, so that paths can be compared.
    ``manipulability_cost`` and ``distance_cost`` as eq. (finew) sums them; w sampled densely along the path;
    ``turning`` rad, the total curvature of the tool's path; ``contact``: the contact found when sampled every
    millimetre, None where the path is free.
    """

    label: str
    nodes: Floats
    q: Floats
    manipulability_cost: float
    distance_cost: float
    w_min: float
    w_mean: float
    joint_length: float
    workspace_length: float
    turning: float
    kinks: Floats
    tool: Floats
    contact: str | None

    def total(self, beta: float) -> float:
        """(1 - beta) Omega + beta D."""
        return combine_costs(beta, self.manipulability_cost, self.distance_cost)

    @property
    def sharp_turns(self) -> int:
        """The number of waypoints where the tool changes direction by more than 45 degrees."""
        return int((self.kinks > KINK).sum())


@dataclass(frozen=True, eq=False)
class SolveFacts:
    """The dynamics at one beta: settling time (s), relative error against Dijkstra, zeta and L."""

    beta: float
    settling_time: float | None
    error: float
    zeta: float
    L: float


@dataclass(frozen=True, eq=False)
class SeedStudy:
    """One seed: its roadmap, its fields, and its paths.

    ``ways``: paths by ``LABELS``; empty where start and goal are not connected. Where the betas do not fall into the
    paper's groups, red is the path of beta = 0 and blue that of beta = 1.
    """

    seed: int
    roadmap: Roadmap
    fields: tuple[SolveFacts, ...]
    ways: dict[str, MeasuredPath]

    def way(self, beta: float) -> MeasuredPath:
        """The path of a beta."""
        return self.ways[label_of(beta)]

    @property
    def red(self) -> MeasuredPath:
        return self.way(0.0)

    @property
    def blue(self) -> MeasuredPath:
        return self.way(1.0)

    @property
    def groups(self) -> tuple[tuple[float, ...], ...]:
        """The betas that share a path, in their order."""
        groups: dict[bytes, list[float]] = {}
        for beta in BETAS:
            groups.setdefault(self.way(beta).nodes.tobytes(), []).append(beta)
        return tuple(map(tuple, groups.values()))

    def ratio(self, name: str) -> float:
        """A measure of the red path over that of the blue one."""
        return getattr(self.red, name) / getattr(self.blue, name)

    def shared(self, rrt: str = RRT) -> float:
        """The largest share of segments that two of the red, the blue and the RRT path have in common."""
        three = self.red.nodes, self.blue.nodes, self.ways[rrt].nodes
        return max(shared_segments(a, b) for a, b in itertools.combinations(three, 2))


def shared_segments(a: Floats, b: Floats) -> float:
    """The share of segments that two joint paths (k, dof) have in common, of the one that has fewer."""
    ends = ([q.tobytes() for q in path] for path in (a, b))
    first, second = ({frozenset(pair) for pair in itertools.pairwise(keys)} for keys in ends)
    return len(first & second) / max(1, min(len(first), len(second)))


@lru_cache(1)
def query_of(request: SweepRequest) -> Query:
    """The iiwa 14 among obstacles, its start and its goals, opened once per process."""
    return make_query(request.what, near_start=False)


def study_seed(k: int, first: SweepRequest) -> SeedStudy:
    """The roadmap of the k-th seed with every path on it; start and goals are those of the ``first``."""
    query, request = query_of(first), first.with_options(seed=first.quality.seed + k)
    ends = query.starts, query.goals
    roadmap = build_roadmap(query.robot, query.checker, *ends, request.quality.nodes, request.quality.seed, refined=0.0)
    fields, paths = [], {}
    for beta in BETAS:
        field, path = _solve(query, roadmap, request, beta)
        fields.append(field)
        if path is not None:
            paths[path.label] = path
    for label, shortcuts in ((RRT, 0), (SHORTENED, GrowthSettings().shortcuts)):
        tree = _tree(query, roadmap, request.quality.seed, shortcuts)
        path = _solve(query, tree, request, 1.0)[1]
        if path is not None:
            paths[label] = replace(path, label=label)
    return SeedStudy(request.quality.seed, roadmap, tuple(fields), paths if len(paths) == len(LABELS) else {})


def _solve(
    query: Query, roadmap: Roadmap, request: SweepRequest, beta: float
) -> tuple[SolveFacts, MeasuredPath | None]:
    """The field of one beta and its path from the start, None where there is none."""
    network = build_network(roadmap, replace(request.quality.objective_at(beta), cost_integration="nodes"))
    result = gabf.solve(network, law=gabf.law_from_name(request.quality.law, request.quality.prescribed_time))
    error = gabf.max_error(result, gabf.oracle(network))
    field = SolveFacts(beta, result.settling_time, error, result.premises.zeta, result.premises.L)
    start = int(roadmap.starts[0])
    if not np.isfinite(result.x[start]):
        return field, None
    nodes = gabf.extract_path(network, result, start)
    return field, _measure(query, roadmap, label_of(beta), nodes, path_cost(network, nodes))


def _measure(query: Query, roadmap: Roadmap, label: str, nodes: Ints, cost: PathCost) -> MeasuredPath:
    """Every measure of the path over ``nodes`` (k,) of ``roadmap``."""
    q = path_waypoints(roadmap, query.robot, nodes)
    tool, contact = sampled_tool_path(query.robot, q), path_contact(query.checker, q)
    return MeasuredPath(
        label=label,
        nodes=roadmap.nodes[nodes],
        q=q,
        manipulability_cost=cost.manipulability,
        distance_cost=cost.distance,
        **asdict(measure_path(query.robot, q)),
        turning=turning(tool),
        kinks=kinks(query.robot, q),
        tool=tool,
        contact=None if contact is None else str(contact.contact),
    )


def _tree(query: Query, roadmap: Roadmap, seed: int, shortcuts: int) -> Roadmap:
    """RRTConnect's path alone, as a roadmap with the costs of ``roadmap``.

    The same seed joins start and goal by the same trees as in the roadmap; two nodes and no links stop there.
    """
    growth, ends = GrowthSettings(shortcuts=shortcuts), (query.starts, query.goals)
    spine = build_roadmap(query.robot, query.checker, *ends, 2, seed, density=0.0, refined=0.0, growth=growth)
    measures = measure_edges(query.robot, spine.nodes, spine.edges, roadmap.scale)
    return replace(spine, scale=roadmap.scale, **measures)
