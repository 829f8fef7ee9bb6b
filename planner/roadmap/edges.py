"""Edges of a growing roadmap: checks of straight motions, results of proofs, and nodes and edges that are added."""

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
from planner.roadmap.measure import check_nodes, measure_edges, unchecked
from planner.roadmap.roadmap import EDGE_ARRAYS, Roadmap


class RecordingProver(EdgeProver):
    """A prover that remembers every free segment's clearance and samples, so that no proof is repeated to get them.

    prover = RecordingProver(checker)
    growth = grow(prover, ...)
    clearance, samples = prover.certificates(growth.nodes, growth.edges)
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
        """The certificate of each motion of the path holds for every piece of it, see :class:`EdgeProver`."""
        whole = self._recall(path[:-1], path[1:])
        for key, motion in zip(self._keys(rows[:-1], rows[1:]), np.repeat(np.arange(len(parts)), parts), strict=True):
            if (known := whole[motion]) is not None:
                self._known.setdefault(key, known)

    def certificates(self, nodes: Floats, edges: Ints) -> tuple[Floats, Ints]:
        """Clearance (m,) metres beyond the margin, never negative, and samples (m,) of proven ``edges`` (m, 2).

        Pieces of a motion that was proven as a whole have what is known of that, see :meth:`note_pieces`, or are proven
        on their own; where that leaves one undecided nothing is claimed for it: clearance 0, no samples.
        """
        a, b = nodes[edges[:, 0]], nodes[edges[:, 1]]
        certificates = self._recall(a, b)
        if missing := _missing(certificates):  # the proof began at the other end
            for row, known in zip(missing, self._recall(b[missing], a[missing]), strict=True):
                certificates[row] = known
        if missing := _missing(certificates):
            self.free(a[missing], self.robot.difference(a[missing], b[missing]))
            for row, known in zip(missing, self._recall(a[missing], b[missing]), strict=True):
                certificates[row] = known
        clearance, samples = np.array([known or (0.0, 0) for known in certificates], dtype=float).reshape(-1, 2).T
        return np.maximum(clearance, 0.0), samples.astype(np.int64)

    def _recall(self, a: Floats, b: Floats) -> list[tuple[float, int] | None]:
        return [self._known.get(key) for key in self._keys(a, b)]

    def _keys(self, a: Floats, b: Floats) -> Iterator[tuple[bytes, bytes]]:
        return zip(row_bytes(a), row_bytes(self.robot.difference(a, b)), strict=True)


def _missing(found: list[tuple[float, int] | None]) -> list[int]:
    return [row for row, known in enumerate(found) if known is None]


class MotionChecker:
    """Motion checks in one world, for one thread; counts nothing, remembers nothing.

    With a ``floor`` > 0 a motion must also keep manipulability above it, in states ``W_IN_GROWTH`` apart. What the
    world's motions keep is looked at in the same states, and proven where a motion is.
    ``resolution`` (m): how much a proof must leave, see :meth:`planner.collision.edge_prover.EdgeProver.prove`.
    """

    def __init__(self, prover: EdgeProver, floor: float = 0.0, resolution: float = PROOF) -> None:
        self.prover, self.robot, self.floor, self.resolution = prover, prover.robot, floor, resolution
        self.constraints = prover.world.constraints
        self._ends_look_free, self._is_free = (
            prover.checker.bound.make_state_check(np.inf),
            prover.each_free(resolution),
        )

    def proven(self, first: Floats, delta: Floats) -> bool:
        """Whether the motion from ``first`` by ``delta`` (dof,) is proven free as a whole."""
        ends_clear = self._ends_look_free(first, delta) and self._well_conditioned(first, delta)
        return ends_clear and self._is_free(first, delta)

    def shorten_path(self, path: Floats) -> Floats:
        """The states (k, dof) of a ``path`` (n, dof) of proven motions that the shortest way along it passes.

        Motions that skip others are proven, to ``resolution``; they turn no joint by half a turn, as angles of such
        ends tell another motion, the shorter one.
        """
        states = self.robot.unwound(path)
        by = states - states[:, None]
        allowed = np.triu(self.robot.is_below_half_turn(by), 1) | np.eye(len(path), k=1, dtype=bool)
        price = np.where(allowed, np.sqrt((by**2).sum(axis=2)), np.inf)
        allows = self._all_well_conditioned if self.floor > 0 else None
        return path[cheapest_chain(self.prover, states, price, self.resolution, allows)]

    def sampling_check(self, step: float) -> MotionCheck:
        """A check of states between which no point moves further than ``step`` (m): quick, and no proof."""
        look = self.prover.checker.bound.make_state_check(step)
        if self.floor <= 0 and not self.constraints:
            return look
        return lambda first, delta: look(first, delta) and self._well_conditioned(first, delta)

    def step(self, longest: float) -> float:
        """How far (rad) trees step, ``longest`` at most: as far as a chord keeps to what is narrow."""
        return min(longest, self.constraints.stride)

    def _all_well_conditioned(self, first: Floats, delta: Floats) -> Bools:
        return np.array([self._well_conditioned(*motion) for motion in zip(first, delta, strict=True)], dtype=bool)

    def _well_conditioned(self, first: Floats, delta: Floats) -> bool:
        if self.floor <= 0 and not self.constraints:
            return True
        count = max(1, int(np.ceil(length(delta) / W_IN_GROWTH)))
        states = first + (np.arange(count + 1) / count)[:, None] * delta
        kept = bool(self.constraints.holds(states).all())
        return kept and (self.floor <= 0 or bool((manipulability(self.robot, states) >= self.floor).all()))


def enlarge_roadmap(
    roadmap: Roadmap, prover: RecordingProver, nodes: Floats, edges: Ints, ends: tuple[Ints, Ints] | None = None
) -> Roadmap:
    """The roadmap with ``nodes`` (k, dof) after its own and those proven ``edges`` (j, 2) that it lacks.

    ``ends``: its starts and goals from then on. The new nodes are checked as
    :func:`planner.roadmap.measure.check_nodes` has it. The margin is that of the weaker proofs; whatever was
    proven with a larger one has so much more clearance.
    """
    robot, everything = prover.robot, np.vstack([roadmap.nodes, nodes])
    edges, place = _lacking(roadmap.edges, edges, len(everything))
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
        checked_by=np.concatenate([roadmap.checked_by, unchecked(len(nodes))]),
        origin=replace(roadmap.origin, margin=margin),
        **{name: _merged(old[name], fresh[name], is_old) for name in EDGE_ARRAYS},
    )
    return check_nodes(bigger, prover.checker, first=len(roadmap.nodes))


def _merged(old: NDArray[Any], fresh: NDArray[Any], is_old: Bools) -> NDArray[Any]:
    """The rows of two arrays in one that is not written to: row after row the next of ``old`` where ``is_old`` (m,)."""
    rows = np.empty((len(is_old), *old.shape[1:]), dtype=old.dtype)
    rows[is_old], rows[~is_old] = old, fresh
    rows.setflags(write=False)
    return rows


def _lacking(known: Ints, edges: Ints, n: int) -> tuple[Ints, Ints]:
    """The ``edges`` that are not among the ``known`` ones, which are sorted, each once; and before which each goes."""
    there, keys = known[:, 0] * n + known[:, 1], np.unique(edges[:, 0] * n + edges[:, 1])
    place = np.searchsorted(there, keys)
    new = np.append(there, -1)[place] != keys
    return np.column_stack([keys[new] // n, keys[new] % n]), place[new]
