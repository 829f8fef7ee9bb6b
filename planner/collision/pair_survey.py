"""Which pairs of links need no self-collision check, by sampling and by proof: what a robot file is written from.

As MoveIt's setup assistant does, pairs are told apart that are adjacent, touch in nearly every random configuration, or
never did. Of the last a sample proves nothing, so a proof is tried: the box of the joints between the two links is
cut into smaller ones until, in the middle of each, the two are farther apart than its joints can move them (the idea
of :mod:`planner.collision.edge_prover`, in as many dimensions as there are joints between).
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.products import product
from planner.base.progress import QUIET, Progress
from planner.collision.checker import APART, CollisionChecker
from planner.collision.self_pairs import ALWAYS, adjacent_pairs
from planner.collision.world import World
from planner.kinematics.forward import joint_placements
from planner.kinematics.reach import pair_reach
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.models.shapes import Mesh

_BATCH = 100  # configurations between two looks at which pairs are decided
_FEW = 1000  # configurations before the proofs: of the others only pairs are asked that neither decides
# boxes of joint values that the proof of one pair may look at: with two joints between the links they suffice for a
# gap of some millimetres, with more joints for links that are well apart
_BOXES_OF_TWO, _BOXES = 200_000, 20_000
_WORK = 130_000  # of all proofs of a robot: looks at pairs of convex bodies, of some 20 microseconds each
_TRIANGLES = 150  # of two bodies, whose look takes as long as another one at convex bodies
_AT_ONCE = 5000  # work in one call of the compiled library, which does not hear Ctrl-C
_ROUNDING = 1e-9  # m by which a computed bound may exceed the distance


class Reason(Enum):
    """Why a pair of links needs no check; ``SOMETIMES``: it does. The values are what a robot file says of them."""

    ADJACENT = "joined by one joint"
    ALWAYS = f"touch in at least {100 * ALWAYS:g} % of the random configurations"
    APART = "cannot touch within the joint limits, the other joints held as they are here: proven"
    NEVER = "never touched in the random configurations, which is no proof"
    SOMETIMES = "touch in some configurations"


@dataclass(frozen=True)
class Survey:
    """The reason found for every pair of links that a joint can move against each other, from ``samples`` samples."""

    reasons: Mapping[frozenset[str], Reason]
    samples: int

    def pairs(self, reason: Reason) -> list[tuple[str, str]]:
        """The pairs of one reason by name, sorted."""
        return sorted((min(pair), max(pair)) for pair, found in self.reasons.items() if found is reason)

    def unchecked(self, trust_samples: bool) -> frozenset[frozenset[str]]:
        """The pairs that need no check; with ``trust_samples`` those too that only were never seen to touch."""
        checked = (Reason.SOMETIMES,) if trust_samples else (Reason.SOMETIMES, Reason.NEVER)
        return frozenset(pair for pair, reason in self.reasons.items() if reason not in checked)


def survey_pairs(
    robot: Robot, backend: type[CollisionChecker], samples: int, seed: int, progress: Progress = QUIET
) -> Survey:
    """Every pair of links that the robot's own files leave checked, with the reason not to; the same for a seed.

    Configurations are uniform within the limits. A pair of links has the strongest reason that holds for all its
    bodies, except that two links always touch if any two of their bodies do.
    """
    adjacent = adjacent_pairs(robot)
    world = World.of(robot, Scene("none"), robot.disabled_pairs or frozenset())
    links = [_links(world, pair) for pair in range(len(world.self_pairs))]
    asked = np.array([pair not in adjacent for pair in links], dtype=bool)
    checker = backend(world)
    sampling = _Sampling(checker, samples, np.random.default_rng(seed), progress)
    sampling.go_on(asked, min(_FEW, samples))
    proofs = _proven(checker, np.flatnonzero(asked & (sampling.touched == 0)).tolist(), progress)
    asked[list(proofs)] = False
    sampling.go_on(asked, samples)
    found: dict[frozenset[str], list[Reason]] = defaultdict(list)
    for pair, names in enumerate(links):
        seen = _seen(sampling.touched[pair] / samples) if asked[pair] else Reason.ADJACENT
        found[names].append(proofs.get(pair, seen))
    return Survey({names: _of_links(each) for names, each in found.items()}, samples)


def _links(world: World, pair: int) -> frozenset[str]:
    first, second = world.self_pairs[pair]
    return frozenset((world.bodies[first].link, world.bodies[second].link))


class _Sampling:
    """Random configurations of a robot: in how many each pair ``touched`` (pairs,).

    As far as it takes to tell never and nearly always from sometimes.
    """

    def __init__(self, checker: CollisionChecker, samples: int, rng: np.random.Generator, progress: Progress) -> None:
        self.touched: Ints = np.zeros(len(checker.world.self_pairs), dtype=np.int64)
        self._checker, self._samples, self._rng, self._progress, self._done = checker, samples, rng, progress, 0

    def go_on(self, asked: Bools, until: int) -> None:
        """Look at the pairs that are ``asked`` (pairs,) for, until there have been so many configurations."""
        robot, bound = self._checker.robot, self._checker.bound
        for first in range(self._done, until, _BATCH):
            missed = first - self.touched
            pairs = np.flatnonzero(asked & ((self.touched == 0) | (missed <= (1 - ALWAYS) * self._samples)))
            q = self._rng.uniform(robot.lower, robot.upper, size=(min(_BATCH, until - first), robot.dof))
            rotation, position = joint_placements(self._checker.chain, q)
            rows, near = np.nonzero(bound.coarse(rotation, position)[:, pairs] <= 0)
            contacts = bound.close(rotation, position, rows, pairs[near], APART) <= 0
            self.touched += np.bincount(pairs[near][contacts], minlength=len(self.touched))
            self._progress("samples", first + len(q), self._samples)
        self._done = until


def _proven(checker: CollisionChecker, pairs: Sequence[int], progress: Progress) -> dict[int, Reason]:
    """The reasons of those ``pairs`` for which one is proven; all are tried side by side, least work first."""
    centre = 0.5 * (checker.robot.lower + checker.robot.upper)
    held = set(checker.inside.all_pairs(centre[None]).tolist())  # one inside the other, and their surfaces never met
    proofs = {pair: _Proof(checker, pair) for pair in pairs if pair not in held}
    waiting, spent = [(0.0, pair) for pair in proofs], 0.0
    while waiting and spent < _WORK:
        done, pair = heapq.heappop(waiting)
        progress("proofs", min(int(spent), _WORK), _WORK)
        proof = proofs[pair]
        proof.go_on()
        spent += proof.work - done
        if proof.found is None:
            heapq.heappush(waiting, (proof.work, pair))
    progress("proofs", _WORK, _WORK)
    found = {pair: proof.found for pair, proof in proofs.items() if proof.found not in (None, Reason.NEVER)}
    return found | dict.fromkeys(held & set(pairs), Reason.ALWAYS)


def _seen(share: float) -> Reason:
    return Reason.ALWAYS if share >= ALWAYS else Reason.SOMETIMES if share > 0 else Reason.NEVER


class _Proof:
    """An attempt to prove that a pair is apart in the whole box of joint values, cut into smaller ones step by step."""

    def __init__(self, whole: CollisionChecker, pair: int) -> None:
        """``whole``: a checker of all pairs."""
        self.found: Reason | None = None  # None: not yet known
        self.work = 0.0
        self._whole, self._pair = whole, pair
        bodies = [whole.world.bodies[k] for k in whole.world.self_pairs[pair]]
        self._price = 1 + sum(len(b.shape.triangles) for b in bodies if isinstance(b.shape, Mesh)) / _TRIANGLES
        self._step = max(1, int(_AT_ONCE / self._price))

    def go_on(self) -> None:
        """Look at the boxes that there are, and cut those that are not decided."""
        if not self.work:
            self._begin()
        centre, half = self._boxes[0][: self._step], self._boxes[1][: self._step]
        need = product(half, self._reach[:, None])[:, 0]
        gap = self._gaps(centre, need)
        self._looks += len(centre)
        self.work += self._price * len(centre)
        if (gap < 0).any() or self._looks > self._most:
            self.found = Reason.SOMETIMES if (gap < 0).any() else Reason.NEVER
            return
        left = gap <= need
        cut = _halved(centre[left], half[left], self._reach)
        self._boxes = tuple(np.concatenate([old[self._step :], new]) for old, new in zip(self._boxes, cut, strict=True))
        if not len(self._boxes[0]):
            self.found = Reason.APART

    def _begin(self) -> None:
        """With the box of all joint values as the only one."""
        robot, world = self._whole.robot, self._whole.world
        reach = pair_reach(robot, *(world.bodies[k] for k in world.self_pairs[self._pair]))
        self._reach = reach @ np.abs(self._whole.chain.coupling)
        self._looks, self._most = 0, _BOXES_OF_TWO if (self._reach > 0).sum() <= 2 else _BOXES
        centre, width = 0.5 * (robot.lower + robot.upper)[None], robot.upper - robot.lower
        leads = np.bincount(self._whole.chain.leader) > 1
        # one turn is all there is, but for what follows in other steps
        width = np.where(robot.prismatic | leads, width, np.minimum(width, 2 * np.pi))
        self._boxes = centre, np.where(self._reach > 0, 0.5 * width, 0.0)[None]

    def _gaps(self, q: Floats, need: Floats) -> Floats:
        """Lower bounds (n,) on the distance, as close as it takes to exceed ``need``; below 0 where the two touch."""
        rotation, position = joint_placements(self._whole.chain, q)
        pairs = np.full(len(q), self._pair)
        gap = self._whole.bound.close(rotation, position, np.arange(len(q)), pairs, need + 2 * _ROUNDING)
        gap -= _ROUNDING
        near = np.flatnonzero(gap <= 0)
        touching = self._whole.distances_in(rotation, position, near, pairs[near]) <= 0
        gap[near[touching]] = -1.0
        return gap


def _halved(centre: Floats, half: Floats, reach: Floats) -> tuple[Floats, Floats]:
    """Each box cut in two across the joint that can move the pair most in it."""
    rows, widest = np.arange(len(centre)), (half * reach).argmax(axis=1)
    half = half.copy()
    half[rows, widest] *= 0.5
    shift = np.zeros_like(half)
    shift[rows, widest] = half[rows, widest]
    return np.concatenate([centre - shift, centre + shift]), np.concatenate([half, half])


def _of_links(reasons: Iterable[Reason]) -> Reason:
    found = set(reasons)
    for reason in (Reason.ADJACENT, Reason.ALWAYS, Reason.SOMETIMES, Reason.NEVER):
        if reason in found:
            return reason
    return Reason.APART
