"""Edges of a growing roadmap: checks of straight motions, results of proofs, additions."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Bools, Floats, Ints, length, row_bytes
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import PROOF, W_IN_GROWTH
from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import EdgeProver, MotionCheck, Proofs
from planner.collision.path_moves import cheapest_chain
from planner.kinematics.manipulability import manipulability, node_manipulability
from planner.roadmap.measure import check_nodes, measure_edges
from planner.roadmap.roadmap import EDGE_ARRAYS, Roadmap


class RecordingProver(EdgeProver):
    """A prover that records the clearance and samples of free segments, so that no proof is repeated.

    prover = RecordingProver(checker) growth = grow(prover, ...) clearance, samples = prover.certificates(growth.nodes,
    growth.edges)
    """

    def __init__(self, checker: CollisionChecker, progress: Progress = QUIET) -> None:
        super().__init__(checker, progress)
        self._known: dict[tuple[bytes, bytes], tuple[float, int]] = {}

    def prove(self, start: Floats, delta: Floats, resolution: float = PROOF, contacts: bool = True) -> Proofs:
        """See :class:`planner.collision.edge_prover.EdgeProver`."""
        start, delta = np.atleast_2d(start), np.atleast_2d(delta)
        proofs = super().prove(start, delta, resolution, contacts)
        free = proofs.free
        self.note(start[free], delta[free], proofs.clearance[free], proofs.samples[free])
        return proofs

    def note(self, start: Floats, delta: Floats, clearance: Floats, samples: Ints) -> None:
        results = zip(clearance.tolist(), samples.tolist(), strict=True)
        self._known |= dict(zip(zip(row_bytes(start), row_bytes(delta), strict=True), results, strict=True))

    def note_pieces(self, path: Floats, rows: Floats, parts: Ints) -> None:
        """Record for each part of a motion the certificate of the motion, see :class:`EdgeProver`."""
        whole = self._recall(path[:-1], path[1:])
        for key, motion in zip(self._keys(rows[:-1], rows[1:]), np.repeat(np.arange(len(parts)), parts), strict=True):
            if (known := whole[motion]) is not None:
                self._known.setdefault(key, known)

    def certificates(self, nodes: Floats, edges: Ints) -> tuple[Floats, Ints]:
        """Return clearance (m,) metres beyond the margin, and samples (m,), of proven ``edges`` (m, 2).

        The clearance is at least 0. Parts of a proven motion have its certificate, see :meth:`note_pieces`, or are
        proven on their own; where that is undecided nothing is claimed: clearance 0, no samples.
        """
        a, b = nodes[edges[:, 0]], nodes[edges[:, 1]]
        certificates = self._recall(a, b)
        if missing := _rows_without_result(certificates):  # the proof began at the other end
            for row, known in zip(missing, self._recall(b[missing], a[missing]), strict=True):
                certificates[row] = known
        if missing := _rows_without_result(certificates):
            self.free(a[missing], self.robot.difference(a[missing], b[missing]))
            for row, known in zip(missing, self._recall(a[missing], b[missing]), strict=True):
                certificates[row] = known
        clearance, samples = np.array([known or (0.0, 0) for known in certificates], dtype=float).reshape(-1, 2).T
        return np.maximum(clearance, 0.0), samples.astype(np.int64)

    def _recall(self, a: Floats, b: Floats) -> list[tuple[float, int] | None]:
        return [self._known.get(key) for key in self._keys(a, b)]

    def _keys(self, a: Floats, b: Floats) -> Iterator[tuple[bytes, bytes]]:
        return zip(row_bytes(a), row_bytes(self.robot.difference(a, b)), strict=True)


def _rows_without_result(results: list[tuple[float, int] | None]) -> list[int]:
    return [row for row, known in enumerate(results) if known is None]


class MotionChecker:
    """Checks of motions in one world, for one thread, without counts and records.

    With a ``floor`` > 0 a motion must also have w above it, in states ``W_IN_GROWTH`` apart. The world's path
    constraints are checked in the same states, and proven with the motion.
    """

    def __init__(self, prover: EdgeProver, floor: float = 0.0, resolution: float = PROOF) -> None:
        self.prover, self.robot, self.floor, self.resolution = prover, prover.robot, floor, resolution
        self.constraints = prover.world.constraints
        self._ends_look_free, self._is_free = (
            prover.checker.bound.make_state_check(np.inf),
            prover.each_free(resolution),
        )

    def is_proven(self, first: Floats, delta: Floats) -> bool:
        """Return whether the motion from ``first`` by ``delta`` (dof,) is allowed and proven free."""
        looks_free = self._ends_look_free(first, delta) and self._is_allowed(first, delta)
        return looks_free and self._is_free(first, delta)

    def shorten_path(self, path: Floats) -> Floats:
        """Return the states (k, dof) of the shortest chain of proven motions through a ``path`` (n, dof).

        Motions that skip others are proven; they turn no joint by half a turn, as their ends do not determine such a
        motion.
        """
        states = self.robot.unwound(path)
        by = states - states[:, None]
        allowed = np.triu(self.robot.is_below_half_turn(by), 1) | np.eye(len(path), k=1, dtype=bool)
        price = np.where(allowed, np.sqrt((by**2).sum(axis=2)), np.inf)
        allows = self._check_motions if self.floor > 0 else None
        return path[cheapest_chain(self.prover, states, price, self.resolution, allows)]

    def make_state_check(self, step: float) -> MotionCheck:
        """Return a quick check of states, no proof; between them no point moves further than ``step`` (m)."""
        look = self.prover.checker.bound.make_state_check(step)
        if self.floor <= 0 and not self.constraints:
            return look
        return lambda first, delta: look(first, delta) and self._is_allowed(first, delta)

    def step(self, longest: float) -> float:
        """Return the step (rad) of trees, ``longest`` at most, shorter under narrow constraints."""
        return min(longest, self.constraints.stride)

    def _check_motions(self, first: Floats, delta: Floats) -> Bools:
        return np.array([self._is_allowed(*motion) for motion in zip(first, delta, strict=True)], dtype=bool)

    def _is_allowed(self, first: Floats, delta: Floats) -> bool:
        if self.floor <= 0 and not self.constraints:
            return True
        count = max(1, int(np.ceil(length(delta) / W_IN_GROWTH)))
        states = first + (np.arange(count + 1) / count)[:, None] * delta
        if not self.constraints.holds(states).all():
            return False
        return self.floor <= 0 or bool((manipulability(self.robot, states) >= self.floor).all())


def enlarge_roadmap(
    roadmap: Roadmap, prover: RecordingProver, nodes: Floats, edges: Ints, ends: tuple[Ints, Ints] | None = None
) -> Roadmap:
    """Return the roadmap with ``nodes`` (k, dof) after its own, and proven ``edges`` (j, 2) that are new.

    ``ends`` are its new starts and goals. :func:`planner.roadmap.measure.check_nodes` checks the new nodes. The margin
    is that of the weaker proofs; proofs with a larger one have so much more clearance.
    """
    robot, everything = prover.robot, np.vstack([roadmap.nodes, nodes])
    edges, place = _missing_edges(roadmap.edges, edges, len(everything))
    clearance, samples = prover.certificates(everything, edges)
    margin = min(roadmap.origin.margin, prover.world.margin)
    fresh = {
        "edges": edges,
        "proven": np.ones(len(edges), dtype=bool),
        **measure_edges(robot, everything, edges, roadmap.scale),
        "clearance": clearance + (prover.world.margin - margin),
        "samples": samples,
    }
    old: dict[str, Any] = {name: getattr(roadmap, name) for name in EDGE_ARRAYS}
    old["clearance"] = old["clearance"] + (roadmap.origin.margin - margin)
    is_old = np.ones(len(roadmap.edges) + len(edges), dtype=bool)
    is_old[place + np.arange(len(edges))] = False
    starts, goals = (roadmap.starts, roadmap.goals) if ends is None else ends
    bigger = replace(
        roadmap,
        nodes=everything,
        starts=starts,
        goals=goals,
        manipulability=np.concatenate([roadmap.manipulability, node_manipulability(robot, nodes)]),
        checked_by=np.concatenate([roadmap.checked_by, np.zeros(len(nodes), dtype=np.int8)]),
        origin=replace(roadmap.origin, margin=margin),
        **{name: _merge_rows(old[name], fresh[name], is_old) for name in EDGE_ARRAYS},
    )
    return check_nodes(bigger, prover.checker, first=len(roadmap.nodes))


def _merge_rows(old: NDArray[Any], fresh: NDArray[Any], is_old: Bools) -> NDArray[Any]:
    """Return the rows of two arrays in one read-only array: the next of ``old`` where ``is_old`` (m,)."""
    rows = np.empty((len(is_old), *old.shape[1:]), dtype=old.dtype)
    rows[is_old], rows[~is_old] = old, fresh
    rows.setflags(write=False)
    return rows


def _missing_edges(known: Ints, edges: Ints, n: int) -> tuple[Ints, Ints]:
    """Return the ``edges`` that the sorted ``known`` lack, each once, and their positions among these."""
    there, keys = known[:, 0] * n + known[:, 1], np.unique(edges[:, 0] * n + edges[:, 1])
    place = np.searchsorted(there, keys)
    new = np.append(there, -1)[place] != keys
    return np.column_stack([keys[new] // n, keys[new] % n]), place[new]
