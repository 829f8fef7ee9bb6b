"""One roadmap of section 4.2: the path of every beta on it, and what RRTConnect found alone, all measured alike."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np

from planner import gabf
from planner.base.arrays import Floats, Ints
from planner.base.progress import QUIET, Progress
from planner.base.shares import traded_off
from planner.construction.build import build_roadmap
from planner.paths.measure import measure_path, path_contact
from planner.planning.network import PathCost, build_network, path_cost
from planner.problem.request import SweepRequest
from planner.reproduce.manipulator.geometry import kinks, sampled_tool_path, turning
from planner.roadmap.measure import measure_edges
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.sampling.growth_settings import GrowthSettings
from planner.setup.open import Query

BETAS = (0.0, 0.3, 0.5, 0.7, 1.0)
"""The betas of section 4.2."""

RRT, SHORTENED = "RRT", "RRT, shortened"
"""RRTConnect's path as it is found, and after the shortcuts with which it becomes the roadmap's first path."""


KINK = np.radians(45.0)


def label_of(beta: float) -> str:
    """The name of a beta's path."""
    return f"beta = {beta:g}"


@dataclass(frozen=True, eq=False)
class MeasuredPath:
    """A path and its measures. ``q`` (k, dof) rad; ``tool`` (n, 3) m, evenly spaced; ``kinks`` (k - 2,) rad.

    ``nodes`` (k, dof): the same as it stands in the roadmap, to the last bit, so that paths can be compared.
    ``manipulability_cost`` and ``distance_cost`` as eq. (finew) sums them; w sampled densely along the path;
    ``turning`` rad, the total curvature of the tool's path; ``contact``: what it touches when sampled every
    millimetre, None where it is free.
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
        return traded_off(beta, self.manipulability_cost, self.distance_cost)

    @property
    def sharp_turns(self) -> int:
        """At how many waypoints the tool changes direction by more than 45 degrees."""
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

    ``ways``: paths by :func:`label_of`, :data:`RRT` and :data:`SHORTENED`; empty where start and goal are not
    connected.
    """

    seed: int
    roadmap: Roadmap
    fields: tuple[SolveFacts, ...]
    ways: dict[str, MeasuredPath]

    def way(self, beta: float) -> MeasuredPath:
        """The path of a beta."""
        return self.ways[label_of(beta)]

    @property
    def groups(self) -> tuple[tuple[float, ...], ...]:
        """The betas that share a path, in their order."""
        groups: dict[bytes, list[float]] = {}
        for beta in BETAS:
            groups.setdefault(self.way(beta).nodes.tobytes(), []).append(beta)
        return tuple(map(tuple, groups.values()))


def study_seed(
    query: Query,
    request: SweepRequest,
    strands: float = 0.0,
    progress: Progress = QUIET,
) -> SeedStudy | None:
    """The roadmap of ``request.seed`` with every path on it, or None if interrupted.

    ``strands``: the share of its nodes that are not RRT's but refined best paths, see :func:`build_roadmap`.
    """
    ends = query.starts, query.goals
    roadmap = build_roadmap(query.robot, query.checker, *ends, request.nodes, request.seed, progress, refined=strands)
    if progress.stopped:
        return None
    fields, paths = [], {}
    for beta in BETAS:
        field, path = _solve(query, roadmap, request, beta)
        fields.append(field)
        if path is not None:
            paths[path.label] = path
    for label, shortcuts in ((RRT, 0), (SHORTENED, GrowthSettings().shortcuts)):
        tree = _tree(query, roadmap, request.seed, shortcuts)
        path = _solve(query, tree, request, 1.0)[1]
        if path is not None:
            paths[label] = replace(path, label=label)
    return SeedStudy(request.seed, roadmap, tuple(fields), paths if len(paths) == len(BETAS) + 2 else {})


def _solve(
    query: Query, roadmap: Roadmap, request: SweepRequest, beta: float
) -> tuple[SolveFacts, MeasuredPath | None]:
    """The field of one beta and its path from the start, None where there is none."""
    network = build_network(roadmap, replace(request.objective_at(beta), charge="nodes"))
    result = gabf.solve(network, law=gabf.named_law(request.law, request.prescribed_time))
    error = gabf.max_error(result, gabf.oracle(network))
    field = SolveFacts(beta, result.settling_time, error, result.premises.zeta, result.premises.L)
    start = int(roadmap.starts[0])
    if not np.isfinite(result.x[start]):
        return field, None
    nodes = gabf.extract_path(network, result, start)
    return field, measure_roadmap_path(query, roadmap, label_of(beta), nodes, path_cost(network, nodes))


def measure_roadmap_path(query: Query, roadmap: Roadmap, label: str, nodes: Ints, cost: PathCost) -> MeasuredPath:
    """Everything measured along the path over ``nodes`` (k,) of ``roadmap``."""
    q = path_waypoints(roadmap, query.robot, nodes)
    tool, found = sampled_tool_path(query.robot, q), path_contact(query.checker, q)
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
        contact=None if found is None else str(found.contact),
    )


def _tree(query: Query, roadmap: Roadmap, seed: int, shortcuts: int) -> Roadmap:
    """RRTConnect's path alone, as a roadmap with the costs of ``roadmap``.

    The same seed joins start and goal by the same trees as in the roadmap; two nodes and no links stop there.
    """
    growth, ends = GrowthSettings(shortcuts=shortcuts), (query.starts, query.goals)
    spine = build_roadmap(query.robot, query.checker, *ends, 2, seed, density=0.0, refined=0.0, growth=growth)
    measures = measure_edges(query.robot, spine.nodes, spine.edges, roadmap.scale)
    return replace(spine, scale=roadmap.scale, **measures)
