"""How well conditioned a path is where it is worst, and what to try where that is bad."""

from __future__ import annotations

import itertools
from collections import deque
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints, quantile
from planner.base.polylines import lengths_along
from planner.base.resolutions import W_AGAINST_FLOOR, W_ALONG_PATH
from planner.kinematics.manipulability import manipulability
from planner.problem.request import PlanQuality
from planner.roadmap.roadmap import Roadmap, component_labels, path_waypoints
from planner.robot.robot import Robot
from planner.search.manipulability_floor import rounded_down
from planner.trajectory.measure import dense_path, dense_segments

POOR = 0.1  # of the typical w: a path that falls below it is called badly conditioned
_MOST_PATHS = 100  # that are sampled anew in search of a reachable floor
_BETTER = 1.2  # a floor is worth trying that is so much higher than the smallest w
_AT_END = 1.05  # the smallest w is an end's if the end's is no larger than so much of it


@dataclass(frozen=True, eq=False)
class Conditioning:
    """Where on a path w is smallest, against what is typical.

    ``typical``: the median of w over the roadmap's nodes. The smallest w lies at ``share`` of the path's length (rad),
    on the way from waypoint ``waypoint`` to the next one, in ``configuration`` (dof,). ``reachable_floor``: a floor
    that some path of the roadmap keeps to, the highest by the states kept of its edges; None where it was not asked
    for, as the path is not ``poor``. ``advice``: a sentence for the user, None where it is not poor.
    """

    w_min: float
    typical: float
    poor: bool
    share: float
    waypoint: int
    configuration: Floats
    reachable_floor: float | None = None
    advice: str | None = None

    def to_dict(self) -> dict[str, Any]:
        return asdict(self) | {"configuration": self.configuration.tolist()}


def judge_conditioning(robot: Robot, roadmap: Roadmap, path: Floats, quality: PlanQuality) -> Conditioning:
    """The judgement on a path (k, dof) of ``roadmap``, sampled ``W_ALONG_PATH`` apart, of a plan of ``quality``."""
    q, segment = dense_segments(path, W_ALONG_PATH)
    w, typical = manipulability(robot, q), quantile(roadmap.manipulability, 0.5)
    lowest = int(w.argmin())
    w_min, poor = float(w[lowest]), bool(w[lowest] < POOR * typical)
    along = lengths_along(q)
    share = float(along[lowest] / along[-1]) if along[-1] > 0 else 0.0
    found = Conditioning(w_min, typical, poor, share, int(segment[lowest]), q[lowest])
    if not poor:
        return found
    floor = reachable_floor(robot, roadmap)
    return replace(found, reachable_floor=floor, advice=_advice(found, w[[0, -1]], floor, quality))


def reachable_floor(robot: Robot, roadmap: Roadmap) -> float:
    """The largest w, rounded down to two digits, above which a path of ``roadmap`` stays all the way; 0 for none.

    That is the smallest w along a widest path. Edges are first taken by the states that are kept of them; those that
    such a path passes are sampled anew every 0.001 rad, until it has none left that was not: w may dip in between.
    """
    least, sampled = roadmap.edge_manipulability.min(axis=1, initial=np.inf), np.zeros(len(roadmap.edges), dtype=bool)
    floor = 0.0
    if not _joins(roadmap, least >= 0.0):
        return floor
    for _ in range(_MOST_PATHS):
        bar = _widest(roadmap, least)
        nodes = _fewest_edges(roadmap, roadmap.edges[least >= bar])
        rows = [roadmap.edge_index(i, j) for i, j in itertools.pairwise(nodes.tolist())]
        if not rows:  # a start that is a goal
            return rounded_down(float(roadmap.manipulability[nodes].min()))
        for row in (row for row in rows if not sampled[row]):
            ends = path_waypoints(roadmap, robot, roadmap.edges[row])
            least[row] = manipulability(robot, dense_path(ends, W_AGAINST_FLOOR)).min()
            sampled[row] = True
        floor = max(floor, float(least[rows].min(initial=np.inf)))
        if floor >= bar:
            break
    return rounded_down(floor)


def _widest(roadmap: Roadmap, least: Floats) -> float:
    """The largest bar such that the edges whose ``least`` (m,) w is no lower join a start and a goal."""
    bars = np.unique(np.append(least, 0.0))
    low, high = 0, len(bars)  # edges from bars[low] up join a start and a goal, those from bars[high] up do not
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _joins(roadmap, least >= bars[middle]) else (low, middle)
    return float(bars[low])


def _joins(roadmap: Roadmap, kept: Bools) -> bool:
    """Whether the edges in the mask ``kept`` (m,) join a start and a goal."""
    labels = component_labels(len(roadmap.nodes), roadmap.edges[kept])
    return bool(np.isin(labels[roadmap.starts], labels[roadmap.goals]).any())


def _fewest_edges(roadmap: Roadmap, edges: Ints) -> Ints:
    """The nodes (k,) of a path from a start to a goal over the fewest of ``edges`` (m, 2), breadth first."""
    neighbours: dict[int, list[int]] = {}
    for i, j in edges.tolist():
        neighbours.setdefault(i, []).append(j)
        neighbours.setdefault(j, []).append(i)
    goals, back = set(roadmap.goals.tolist()), dict.fromkeys(roadmap.starts.tolist(), -1)
    waiting = deque(back)
    while waiting:
        here = waiting.popleft()
        if here in goals:
            nodes = [here]
            while back[nodes[-1]] >= 0:
                nodes.append(back[nodes[-1]])
            return np.array(nodes[::-1])
        for there in neighbours.get(here, []):
            if there not in back:
                back[there] = here
                waiting.append(there)
    raise AssertionError("start and goal are joined")


def _advice(found: Conditioning, ends: Floats, floor: float, quality: PlanQuality) -> str:
    """What is bad about a poor path whose ends have the w ``ends`` (2,), and what to try."""
    at_ends = [end for end, w in zip(("start", "goal"), ends, strict=True) if w <= _AT_END * found.w_min]
    where = f"at the {at_ends[0]} itself" if at_ends else f"at {100 * found.share:.0f} % of the path"
    percent = 100 * found.w_min / found.typical
    tries = []
    if floor > _BETTER * max(found.w_min, quality.min_manipulability):
        tries.append(f"--min-manipulability {floor:g}, above which a path of this roadmap stays")
    if quality.beta == 1.0:
        tries.append("a --beta below 1")
    elif quality.charge == "nodes":
        tries.append("--charge edges")
    if not tries:
        tries = [f"another {at_ends[0]}"] if at_ends else ["more --nodes", "another --seed"]
    return (
        f"Badly conditioned {where}: w {found.w_min:.2g} there is {percent:.2g} % of the roadmap's median "
        f"{found.typical:.2g}. Try {'; or '.join(tries)}."
    )
