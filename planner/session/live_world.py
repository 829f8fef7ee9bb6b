"""Robot, scene and roadmap as they stand now, and what a change makes of them: a new whole, or an error and nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from planner.base.arrays import Bools, Floats, Ints
from planner.base.errors import SceneError, choices
from planner.base.yamlfile import SMALLEST, validate
from planner.collision.checker import CollisionChecker, contact_of, is_free
from planner.collision.edge_prover import EdgeProver
from planner.collision.world import Contact, World
from planner.problem.request import WorldRequest
from planner.query.in_hand import let_go, taken
from planner.query.query import open_world
from planner.query.resolve import touching
from planner.roadmap.node_checks import nobody
from planner.roadmap.roadmap import EDGE_ARRAYS, NODE_ARRAYS, Roadmap, origin_of
from planner.robot.frames import in_world
from planner.robot.moving import MovingObstacle
from planner.robot.robot import Robot, with_carried
from planner.robot.scene import PoseFile, Scene
from planner.robot.shapes import Box, Mesh, Obstacle, Shape
from planner.session.edge_proofs import EdgeProofs, displacement


@dataclass(frozen=True, eq=False)
class LiveWorld:
    """What a session is at one moment.

    ``bare``: the robot without what it carries. ``kept`` is the roadmap (None until the first query): it holds every
    edge that was ever proven, ``proofs`` what is known of each now (nothing without it); its first ``lasting`` nodes
    stay, the others came with queries. ``stands`` (k, dof): where the arm may stand.
    """

    bare: Robot
    checker: CollisionChecker
    proofs: EdgeProofs
    stands: Floats
    kept: Roadmap | None = None
    lasting: int = 0

    @staticmethod
    def of(request: WorldRequest) -> LiveWorld:
        """The world that a request names, without a roadmap."""
        scene = request.scene if isinstance(request.scene, Scene) else Scene.load(str(request.scene))
        checker = open_world(replace(request, scene=replace(scene, carried=())))
        bare = checker.robot
        live = LiveWorld(bare, checker, EdgeProofs.of(checker.world, np.zeros(0)), np.zeros((0, bare.dof)))
        return live._in(in_world(scene, bare))

    @property
    def roadmap(self) -> Roadmap:
        assert self.kept is not None  # whoever asks has seen to that
        return self.kept

    def with_roadmap(self, roadmap: Roadmap) -> LiveWorld:
        """With a roadmap that is proven in this very world."""
        proofs = EdgeProofs.of(self.world, roadmap.clearance + (roadmap.origin.margin - self.world.margin))
        return replace(self, kept=roadmap, proofs=proofs, lasting=len(roadmap.nodes))

    @cached_property
    def prover(self) -> EdgeProver:
        return EdgeProver(self.checker)

    @property
    def world(self) -> World:
        return self.checker.world

    @property
    def scene(self) -> Scene:
        return self.world.scene

    def add(self, obstacle: Obstacle | MovingObstacle) -> LiveWorld:
        """With one obstacle more."""
        _require_new_name(self, obstacle.name)
        _require_sound(obstacle)
        if isinstance(obstacle, MovingObstacle):  # the world that stands still is as it was
            return self._in(replace(self.scene, moving=(*self.scene.moving, obstacle)))
        return self._in(replace(self.scene, obstacles=(*self.scene.obstacles, obstacle)))

    def move(self, name: str, data: Mapping[str, Any]) -> LiveWorld:
        """With the obstacle ``name`` at another place; ``data``: a pose as scene files write it, in parts or whole."""
        old = self._obstacle(name)
        found = validate(PoseFile, dict(data), f"the move of '{name}'", SceneError)
        placement = np.array(found.matrix())
        if "position" not in data:
            placement[:3, 3] = old.placement[:3, 3]
        if found.rpy is None and found.quaternion is None:
            placement[:3, :3] = old.placement[:3, :3]
        return self.put(name, placement)

    def put(self, name: str, placement: Floats) -> LiveWorld:
        """With the obstacle ``name`` placed (4, 4) anew in the world."""
        old = self._obstacle(name)
        if np.array_equal(old.placement, placement):
            return self
        new = replace(old, placement=placement)
        obstacles = tuple(new if item is old else item for item in self.scene.obstacles)
        world = self.world.with_places(replace(self.scene, obstacles=obstacles))
        if self.kept is None:
            return self._in_world(world)
        moved = self.proofs.moved(name, displacement(old.shape, old.placement, placement))
        return replace(self, proofs=moved)._in_world(world)

    def remove(self, name: str) -> LiveWorld:
        """Without the obstacle ``name``."""
        if name in {item.name for item in self.scene.moving}:
            return self._in(replace(self.scene, moving=tuple(o for o in self.scene.moving if o.name != name)))
        old = self._obstacle(name)
        obstacles = tuple(o for o in self.scene.obstacles if o is not old)
        allowed = self.scene.allowed
        if old.object not in {item.object for item in obstacles}:
            allowed = frozenset(pair for pair in allowed if old.object not in pair)
        return self._in(replace(self.scene, obstacles=obstacles, allowed=allowed))

    def attach(self, name: str, frame: str, touch_links: tuple[str, ...], q: Floats) -> LiveWorld:
        """With the obstacle ``name`` in the hold of ``frame``, as it stands to it in the configuration ``q`` (dof,)."""
        old = self._obstacle(name)
        links = {body.link for body in self.bare.bodies}
        unknown = sorted(set(touch_links) - links)
        if unknown:
            raise SceneError(
                f"link '{unknown[0]}' cannot touch '{name}': links with shapes are {choices(sorted(links))}."
            )
        return self._in(taken(self.scene, old, self.bare, frame, q, touch_links), other=name)

    def detach(self, name: str, q: Floats) -> LiveWorld:
        """With what was carried standing where the arm holds it in ``q`` (dof,); what might touch it still may."""
        item = next((item for item in self.scene.carried if item.name == name), None)
        if item is None:
            raise SceneError(f"'{name}' is not carried; the arm carries {choices(i.name for i in self.scene.carried)}.")
        allowed = self.scene.allowed | {frozenset((name, link)) for link in (item.link, *item.touch_links)}
        return self._in(replace(let_go(self.scene, item, self.bare, q), allowed=allowed), other=name)

    def proven(self, rows: Ints) -> LiveWorld:
        """After a proof of what is open of the edges ``rows``."""
        return replace(self, proofs=self.proofs.proven(self.prover, self.roadmap, rows)) if len(rows) else self

    def held(self, edges: Bools) -> Roadmap:
        """The roadmap of all nodes and of some ``edges`` (m,), with what is known of these now."""
        clearance = np.maximum(np.nan_to_num(self.proofs.clearance, nan=0.0, posinf=np.inf), 0.0)
        whole = replace(
            self.roadmap,
            proven=self.proofs.free,
            clearance=clearance,
            origin=origin_of(self.checker, self.roadmap.origin.seed),
        )
        return whole.part(np.ones(len(whole.nodes), dtype=bool), edges)

    def enlarged(self, bigger: Roadmap) -> LiveWorld:
        """With what a roadmap that grew from a part of this one has more: nodes after ours, edges proven just now."""
        n, old = len(bigger.nodes), self.roadmap
        mine, theirs = (edges[:, 0] * n + edges[:, 1] for edges in (old.edges, bigger.edges))
        known_free = mine[self.proofs.free | self.proofs.open]
        fresh = ~np.isin(theirs, known_free)
        kept = ~np.isin(mine, theirs[fresh])
        whole = {name: np.concatenate([getattr(old, name)[kept], getattr(bigger, name)[fresh]]) for name in EDGE_ARRAYS}
        order = np.argsort(np.concatenate([mine[kept], theirs[fresh]]), kind="stable")
        new = EdgeProofs.of(self.world, bigger.clearance[fresh])
        arrays = {name: array[order] for name, array in whole.items()}
        nodes = {name: getattr(bigger, name) for name in NODE_ARRAYS}
        roadmap = replace(old, starts=bigger.starts, goals=bigger.goals, **nodes, **arrays)
        return replace(self, kept=roadmap, proofs=self.proofs.rows(kept).followed_by(new).rows(order))

    def without_nodes(self, keep: Bools) -> LiveWorld:
        """With the nodes (n,) in ``keep`` and the edges between them only."""
        edges: Bools = np.all(keep[self.roadmap.edges], axis=1)
        return replace(self, kept=self.roadmap.part(keep, edges), proofs=self.proofs.rows(edges))

    def _obstacle(self, name: str) -> Obstacle:
        for obstacle in self.scene.obstacles:
            if obstacle.name == name:
                return obstacle
        held = " (it is carried: detach it first)" if name in {item.name for item in self.scene.carried} else ""
        if name in {item.name for item in self.scene.moving}:
            held = " (it goes along a known motion: remove it and add it anew)"
        names = choices(obstacle.name for obstacle in self.scene.obstacles)
        raise SceneError(f"obstacle '{name}' not found{held}; obstacles are {names}.")

    def _in(self, scene: Scene, other: str | None = None) -> LiveWorld:
        """In another scene, where ``other`` is what it was not before."""
        robot = self.checker.robot
        if scene.carried != self.scene.carried:
            robot = with_carried(self.bare, scene.carried)
        return self._in_world(self.world.among(scene, robot), other)

    def _in_world(self, world: World, other: str | None = None) -> LiveWorld:
        """The same of its world; raises :class:`SceneError` where something is put into the robot."""
        checker = type(self.checker)(world, self.checker)
        after = replace(self, checker=checker)
        if self.kept is not None:
            kept = replace(self.kept, checked_by=nobody(len(self.kept.nodes)))  # that was another world
            after = replace(after, proofs=self.proofs.in_world(world, other), kept=kept)
        contact = checker.static_contact or _new_contact(self.checker, checker, self.stands)
        if contact is not None:
            sentence = f"after this change {contact} {contact.how(world.margin)}: choose another place."
            raise SceneError(sentence, touching("world", contact))
        return after


def _new_contact(before: CollisionChecker, after: CollisionChecker, stands: Floats) -> Contact | None:
    """What touches now where the arm may stand (k, dof), if that is everywhere where nothing did before."""
    found = [contact_of(after, q) for q in stands]
    if None in found:
        return None
    fresh = [contact for q, contact in zip(stands, found, strict=True) if is_free(before, q)]
    return fresh[0] if fresh else None


def _require_new_name(live: LiveWorld, name: str) -> None:
    links = {body.link for body in live.bare.bodies}
    taken = {item.name for item in (*live.scene.obstacles, *live.scene.carried, *live.scene.moving)} | links
    if not name or name in taken:
        what = "no name" if not name else f"the name '{name}', which is taken"
        raise SceneError(f"the obstacle has {what}: give it one that differs from those of obstacles and links.")


def _require_sound(obstacle: Obstacle | MovingObstacle) -> None:
    """Refuse sizes that the collision libraries take for none; what is no size at all, no shape has."""
    if not _sizes(obstacle.shape).min() >= SMALLEST:
        raise SceneError(f"obstacle '{obstacle.name}' has an unusable size: give sizes in metres from {SMALLEST:g} on.")


def _sizes(shape: Shape) -> Floats:
    match shape:
        case Box(size):
            return np.array(size, dtype=float)
        case Mesh(vertices, _):
            return np.array([np.ptp(vertices, axis=0).max()])
        case _:
            return np.array(list(vars(shape).values()), dtype=float)
