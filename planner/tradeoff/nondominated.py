"""All non-dominated paths under two costs: a label-setting search, guided and pruned by lower bounds."""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints, frozen
from planner.base.errors import AssumptionError, OptionError
from planner.base.progress import QUIET, Progress

MAX_LABELS = 1_000_000
_TOLERANCE = 1e-12  # relative to max(1, cost): paths this close in both costs are one point
_REPORT = 4096  # labels between two words on the progress


@dataclass(frozen=True, eq=False)
class Front:
    """Paths of which none is better in one cost without being worse in the other, one per pair of costs.

    ``points`` (k, 2) Omega and D, Omega ascending, so D descends; ``paths`` their nodes, start first. ``complete`` is
    False where the search was stopped: the points are then those of least Omega, and there may be more of larger
    Omega. ``labels`` counts the partial paths that were made.
    """

    points: Floats
    paths: tuple[Ints, ...]
    complete: bool
    labels: int


def non_dominated(
    indptr: Ints,
    heads: Ints,
    costs: Floats,
    starts: Ints,
    goals: Ints,
    bounds: Floats,
    max_labels: int = MAX_LABELS,
    progress: Progress = QUIET,
) -> Front:
    """Every non-dominated pair of costs over the paths from a start to a goal, with a path for each.

    Node i leads to ``heads[indptr[i]:indptr[i + 1]]`` at ``costs`` (n_arcs, 2). ``bounds`` (n, 2): for each cost alone
    the least from a node to a goal, or less, +inf where there is no path. Labels leave a heap by Omega, then D, both
    with the bound of the rest, so goals are reached in the order of Omega, each time at a smaller D; a label is dropped
    where its node, or with the bound of the rest a goal, was reached at no larger D before. That is BOA* of C.
    Hernandez et al., Simple and efficient bi-objective search algorithms via fast dominance checks, Artificial
    Intelligence 314, 2023, with several starts and goals. Stops, incomplete, at ``max_labels`` or when asked to.

    Costs closer than 1e-12 (relative to max(1, cost)) count as equal. Raises AssumptionError for costs below 0 and for
    bounds that exceed an arc's cost and the bound behind it, OptionError for ``max_labels`` below 1.
    """
    require_labels(max_labels)
    _require_bounds(indptr, heads, costs, goals, bounds)
    search = _Search(indptr, heads, costs, starts, goals, bounds)
    complete = search.run(max_labels, progress)
    found = [search.path(label) for label in search.reached]
    points = np.array([costs[arcs].sum(axis=0) for _, arcs in found]).reshape(-1, 2)
    kept = _undominated(points)
    paths = tuple(frozen(found[k][0], np.int64) for k in kept)
    return Front(frozen(points[kept]), paths, complete, len(search.node))


def require_labels(max_labels: int) -> None:
    """Raise :class:`OptionError` unless so many labels allow a search."""
    if max_labels < 1:
        raise OptionError(f"{max_labels} labels make no search: give a whole number from 1.")


class _Search:
    """The labels as lists that grow: where each stands, at which costs, which label and which arc led there."""

    def __init__(self, indptr: Ints, heads: Ints, costs: Floats, starts: Ints, goals: Ints, bounds: Floats) -> None:
        self.indptr, self.heads = indptr.tolist(), heads.tolist()
        self.omega, self.weight = costs.T.tolist()
        self.rest_omega, self.rest_distance = bounds.T.tolist()
        self.goals = set(goals.tolist())
        self.least = [np.inf] * len(bounds)  # the D at which a node was last reached: it only falls
        self.best = np.inf  # the same over all goals
        self.node: list[int] = []
        self.parent: list[int] = []
        self.arc: list[int] = []
        self.cost: list[tuple[float, float]] = []
        self.heap: list[tuple[float, float, int]] = []
        self.reached: list[int] = []
        for start in starts.tolist():
            if np.isfinite(bounds[start]).all():
                self._push(start, -1, -1, 0.0, 0.0)

    def run(self, max_labels: int, progress: Progress) -> bool:
        """Whether the heap was emptied."""
        told = 0
        while self.heap:
            if len(self.node) >= told:
                progress("front", len(self.node), max_labels)
                told = len(self.node) + _REPORT
                if progress.stopped:
                    return False
            _, distance, label = heapq.heappop(self.heap)
            here, (_, spent) = self.node[label], self.cost[label]
            if spent >= self.least[here] - _slack(spent) or distance >= self.best - _slack(distance):
                continue
            if len(self.node) >= max_labels:
                return False
            self.least[here] = spent
            if here in self.goals:
                self.best = spent
                self.reached.append(label)
            else:
                self._expand(label)
        progress("front", len(self.node), len(self.node))
        return True

    def _expand(self, label: int) -> None:
        here, (omega, distance) = self.node[label], self.cost[label]
        for arc in range(self.indptr[here], self.indptr[here + 1]):
            there, further = self.heads[arc], distance + self.weight[arc]
            reach = further + self.rest_distance[there]
            # written so that +inf, a node without a path to a goal, is dropped too
            if further < self.least[there] - _slack(further) and reach < self.best - _slack(further):
                self._push(there, label, arc, omega + self.omega[arc], further)

    def _push(self, node: int, parent: int, arc: int, omega: float, distance: float) -> None:
        label = len(self.node)
        self.node.append(node)
        self.parent.append(parent)
        self.arc.append(arc)
        self.cost.append((omega, distance))
        heapq.heappush(self.heap, (omega + self.rest_omega[node], distance + self.rest_distance[node], label))

    def path(self, label: int) -> tuple[Ints, Ints]:
        """Nodes and arcs that led to a label, start first."""
        nodes, arcs = [self.node[label]], []
        while self.parent[label] >= 0:
            arcs.append(self.arc[label])
            label = self.parent[label]
            nodes.append(self.node[label])
        return np.array(nodes[::-1], dtype=np.int64), np.array(arcs[::-1], dtype=np.int64)


def _undominated(points: Floats) -> list[int]:
    """Rows in the order of Omega; sums of the same costs in another order differ by rounding, so compare once more."""
    kept: list[int] = []
    for k in np.lexsort((points[:, 1], points[:, 0])).tolist():
        omega, distance = points[k].tolist()
        if kept and distance >= points[kept[-1], 1] - _slack(distance):
            continue
        while kept and points[kept[-1], 0] >= omega - _slack(omega):
            kept.pop()
        kept.append(k)
    return kept


def _slack(cost: float) -> float:
    return _TOLERANCE * (cost if cost > 1.0 else 1.0)


def _require_bounds(indptr: Ints, heads: Ints, costs: Floats, goals: Ints, bounds: Floats) -> None:
    """Bounds that grow along an arc by more than it costs would let paths be dropped that are not dominated."""
    if (costs < 0.0).any() or (bounds[goals] > 0.0).any():
        raise AssumptionError("costs must not be negative, nor the bounds at goals positive")
    tails = np.repeat(np.arange(indptr.size - 1), np.diff(indptr))
    behind = costs + bounds[heads]
    wrong = np.flatnonzero((bounds[tails] > behind + 1e-9 * np.maximum(1.0, behind)).any(axis=1))
    if wrong.size:
        raise AssumptionError(
            f"the bound at node {tails[wrong[0]]} exceeds that at node {heads[wrong[0]]} by more than the arc between "
            "them costs: give the least costs to a goal"
        )
