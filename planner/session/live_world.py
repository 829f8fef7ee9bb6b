"""A robot in a scene that changes, shared by sessions and gates."""

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np

from planner.base.arrays import Floats, is_placement, numbers
from planner.base.errors import Note, SceneError, StateError, choices
from planner.base.yamlfile import FARTHEST, validate
from planner.collision.checker import CollisionChecker
from planner.collision.self_filter import prepare_scene, without_robot
from planner.kinematics.forward import tool_pose
from planner.problem.request import WorldRequest
from planner.query.query import make_checker_for
from planner.query.resolve import contact_reason
from planner.query.robots import attach_object, detach_object, open_cell
from planner.robot.clouds import Points, Voxels, notes_on_clouds, split_blocks
from planner.robot.depth_image import DepthImage
from planner.robot.moving import MovingObstacle
from planner.robot.poses import pose
from planner.robot.robot import Robot, with_carried
from planner.robot.scene import PoseFile, Scene, build_obstacles
from planner.robot.shapes import Carried, Obstacle
from planner.session.permissions import Permission

_REVISIONS = count()


class LiveWorld:
    """The current robot, scene and carried objects, in a collision checker.

    A change makes a new checker, or raises :class:`SceneError` and changes nothing. Earlier checkers stay valid, so one
    thread can change the world while others finish in the world in which they began.
    """

    def __init__(self, request: WorldRequest) -> None:
        """Open the world of ``request``; :class:`PlannerError` for unusable input."""
        request = open_cell(request)
        scene = Scene.load(request.scene)
        checker = make_checker_for(replace(request, scene=replace(scene, carried=())))
        self._changing = threading.Lock()
        self.bare: Robot = checker.robot
        """The robot without carried objects."""
        self.now: tuple[CollisionChecker, int] = checker, next(_REVISIONS)
        """The checker and its revision, which grows with every change and is unique in the process."""
        self.permissions: tuple[Permission, ...] = ()
        """Contacts that gates allow for a time or in a region."""
        self._change(lambda _: prepare_scene(scene, with_carried(self.bare, scene.carried)))

    @property
    def checker(self) -> CollisionChecker:
        return self.now[0]

    @property
    def robot(self) -> Robot:
        """The robot with carried objects."""
        return self.checker.robot

    @property
    def scene(self) -> Scene:
        """The scene, with carried objects."""
        return self.checker.world.scene

    def add(self, obstacle: Obstacle | MovingObstacle | Mapping[str, Any]) -> None:
        """Add an obstacle, or a dict with its keys as in :class:`planner.Scene`."""
        (item,), notes = build_obstacles([obstacle], "the obstacle")
        self._change(lambda scene: self._with_obstacle(scene, item, notes))

    def move(
        self,
        name: str,
        position: Iterable[float] | None = None,
        rpy: Iterable[float] | None = None,
        quaternion: Iterable[float] | None = None,
    ) -> None:
        """Move an obstacle to another pose, in the notation of scene files; omitted values stay.

        A ``position`` can be a whole pose, (4, 4) or ``pinocchio.SE3``.
        """
        if is_placement(position):
            return self.put(name, pose(position, rpy, quaternion))  # type: ignore[arg-type]
        given = {"position": position, "rpy": rpy, "quaternion": quaternion}
        data = {key: np.asarray(value).tolist() for key, value in given.items() if value is not None}
        file = validate(PoseFile, data, f"the move of '{name}'", SceneError)
        placement, old = np.array(file.matrix()), _find_obstacle(self.scene, name).placement
        if position is None:
            placement[:3, 3] = old[:3, 3]
        if rpy is None and quaternion is None:
            placement[:3, :3] = old[:3, :3]
        self.put(name, placement)

    def put(self, name: str, placement: Floats) -> None:
        """Move an obstacle to another ``placement`` (4, 4) in the world."""

        def place_in(scene: Scene) -> Scene:
            old = _find_obstacle(scene, name)
            new = replace(old, placement=placement)
            return replace(scene, obstacles=tuple(new if item is old else item for item in scene.obstacles))

        self._change(place_in)

    def remove(self, name: str) -> None:
        """Remove an obstacle."""

        def remove_from(scene: Scene) -> Scene:
            if name in {item.name for item in scene.moving}:
                return replace(scene, moving=tuple(item for item in scene.moving if item.name != name))
            old, allowed = _find_obstacle(scene, name), scene.allowed
            obstacles = tuple(item for item in scene.obstacles if item is not old)
            if old.object not in {item.object for item in obstacles}:
                allowed = frozenset(pair for pair in allowed if old.object not in pair)
            return replace(scene, obstacles=obstacles, allowed=allowed)

        self._change(remove_from)

    def see(
        self,
        name: str,
        seen: Points | Voxels | DepthImage,
        placement: Floats | None = None,
        q: Floats | None = None,
        margin: float = 0.02,
    ) -> None:
        """Replace the data of the sensor ``name``, at a ``placement`` (4, 4) in the world.

        Blocks of points or voxels that are as before stay the same obstacles, so that nothing near them is proven
        again. A depth image has its own placement. Where ``q`` (dof,) is given, the arm stood there, and what is within
        ``margin`` (m) of it is left out.
        """
        at = np.eye(4) if placement is None else placement

        def replace_seen(scene: Scene) -> Scene:
            old = [item for item in scene.obstacles if item.object == name]
            shown = seen.obstacles(name) if isinstance(seen, DepthImage) else (Obstacle(name, seen, at),)
            if q is not None:
                shown = without_robot(shown, self.robot, self._require_configuration(q), margin)
            new: list[Obstacle] = []
            for item in shown:
                new += split_blocks(replace(item, object_id=name), old)
            others = [item for item in scene.obstacles if item.object != name]
            if repeated := {item.name for item in new} & ({item.name for item in others} | self._links()):
                raise SceneError(f"sensor '{name}': obstacle '{min(repeated)}' is there already: take another name.")
            order = {id(item): k for k, item in enumerate(old)}
            new.sort(key=lambda item: order.get(id(item), len(order)))
            stale = notes_on_clouds(scene.obstacles)
            notes = tuple(note for note in scene.notes if note not in stale)
            return replace(scene, obstacles=(*others, *new), notes=notes)

        self._change(replace_seen)

    def allow(
        self, link: str, object: str, seconds: float | None = None, box: Floats | Sequence[float] | None = None
    ) -> None:
        """Allow a link or a carried object to touch an obstacle; all other pairs are checked as before.

        For ``seconds`` from now on or inside ``box`` (x0, y0, z0, x1, y1, z1 in m, in the world) it holds for gates
        only: sessions plan as before. A gate proves that the pair is apart at any other time, and wherever a part of
        the link is outside the box. Without both the scene allows the contact, for sessions too. A second call for the
        same pair replaces the first. :meth:`forbid` ends it, and so does the removal of the obstacle. Raises
        :class:`SceneError` for unknown names, and :class:`OptionError` for unusable values.
        """
        permission = Permission.from_now(link, object, seconds, box, tool_pose(self.bare, self.bare.home).translation)
        self._require_pair(link, object)
        always = seconds is None and box is None
        self._permit(link, object, always, () if always else (permission,))

    def forbid(self, link: str, object: str) -> None:
        """End the permission of a pair to touch; :class:`SceneError` if it has none."""
        known = any(item.is_of(link, object) for item in self.permissions)
        if not known and frozenset((link, object)) not in self.scene.allowed:
            raise SceneError(f"contact of '{link}' and '{object}' must be allowed, got none: allow it first.")
        self._permit(link, object, False, ())

    def _permit(self, link: str, object: str, always: bool, permission: tuple[Permission, ...]) -> None:
        """Replace the permission of a pair."""
        pair = frozenset((link, object))
        if always is not (pair in self.scene.allowed):
            self._change(lambda scene: replace(scene, allowed=scene.allowed ^ {pair}))
        with self._changing:
            others = (item for item in self.permissions if not item.is_of(link, object))
            self.permissions, self.now = (*others, *permission), (self.checker, next(_REVISIONS))

    def attach(
        self, name: str | Obstacle | Mapping[str, Any], frame: str, q: Floats, touch_links: Sequence[str] = ()
    ) -> None:
        """Attach an obstacle to ``frame`` at their relative pose in the configuration ``q`` (dof,).

        ``name`` is that of an obstacle of the scene, or a new obstacle. The placement of a new one whose own ``frame``
        is this frame is relative to it, as for a box around what the fingers hold.
        """
        links, q = tuple(touch_links), self._require_configuration(q)
        unknown = sorted(set(links) - self._links())
        if unknown:
            raise SceneError(
                f"link '{unknown[0]}' cannot touch '{name}': links with shapes are {choices(sorted(self._links()))}."
            )
        if isinstance(name, str):
            return self._change(
                lambda scene: attach_object(scene, _find_obstacle(scene, name), self.bare, frame, q, links)
            )
        (item,), notes = build_obstacles([name], "the obstacle")
        if isinstance(item, MovingObstacle) or item.frame not in ("", frame):
            raise SceneError(
                f"obstacle '{item.name}' must stand in the world or in '{frame}': give its placement there."
            )

        def attach_new(scene: Scene) -> Scene:
            there = self._with_obstacle(scene, item, notes)
            if not item.frame:
                return attach_object(there, item, self.bare, frame, q, links)
            held = Carried(frame, item.name, item.shape, item.placement, links, speed_limit=item.speed_limit)
            return replace(there, obstacles=scene.obstacles, carried=(*scene.carried, held))

        self._change(attach_new)

    def detach(self, name: str, q: Floats) -> None:
        """Detach a carried object at its pose in ``q`` (dof,); allowed contacts stay allowed."""
        q = self._require_configuration(q)

        def put_down(scene: Scene) -> Scene:
            item = _find_carried(scene, name)
            allowed = scene.allowed | {frozenset((name, link)) for link in (item.link, *item.touch_links)}
            return replace(detach_object(scene, item, self.bare, q), allowed=allowed)

        self._change(put_down)

    def restore(self, checker: CollisionChecker) -> None:
        """Return to an earlier state of this world, given by its ``checker``."""
        with self._changing:
            self.now = checker, next(_REVISIONS)

    def _require_configuration(self, q: Floats) -> Floats:
        return numbers("q", q, (self.bare.dof,), StateError, FARTHEST)

    def _links(self) -> set[str]:
        return {body.link for body in self.bare.bodies}

    def _with_obstacle(self, scene: Scene, item: Obstacle | MovingObstacle, notes: tuple[Note, ...]) -> Scene:
        """Return the scene with a new obstacle; :class:`SceneError` for a name that is used."""
        names = {item.name for item in (*scene.obstacles, *scene.carried, *scene.moving)} | self._links()
        if not item.name or item.name in names:
            raise SceneError(
                f"obstacle name must be new and not empty, got '{item.name}': choose one without obstacle or link."
            )
        return replace(scene, obstacles=(*scene.obstacles, item), notes=(*scene.notes, *notes))

    def _require_pair(self, link: str, object: str) -> None:
        """Raise :class:`SceneError` unless a link or carried object and an obstacle have these names."""
        links = self._links() | {item.object for item in self.scene.carried}
        objects = {item.object for item in self.scene.obstacles}
        for what, name, known in (("link", link, links), ("object", object, objects)):
            if name not in known:
                raise SceneError(f"{what} '{name}' not found; {what}s that can touch are {choices(sorted(known))}.")

    def _change(self, apply: Callable[[Scene], Scene]) -> None:
        """Make the next checker; :class:`SceneError` for a contact that no motion of joints can end."""
        with self._changing:
            before = self.checker
            world, old = before.world, before.world.scene
            scene = apply(old)
            if _has_same_objects(old, scene):
                world = world.with_placements(scene)
            else:
                robot = world.robot if scene.carried == old.carried else with_carried(self.bare, scene.carried)
                world = world.among(scene, robot)
            checker = type(before)(world, before)
            contact = checker.static_contact
            if contact is not None:
                sentence = f"after this change {contact} {contact.how(world.margin)}: choose another pose."
                raise SceneError(sentence, contact_reason("world", contact))
            gone = {item.object for item in old.obstacles} - {
                item.object for item in (*scene.obstacles, *scene.carried)
            }
            self.permissions = tuple(item for item in self.permissions if item.object not in gone)
            self.now = checker, next(_REVISIONS)


def _has_same_objects(old: Scene, new: Scene) -> bool:
    """Whether two scenes differ at most in the poses of their obstacles."""
    if new.carried != old.carried or new.allowed != old.allowed or len(new.obstacles) != len(old.obstacles):
        return False
    pairs = zip(old.obstacles, new.obstacles, strict=True)
    return all(a is b or (a.name == b.name and a.shape is b.shape) for a, b in pairs)


def _find_obstacle(scene: Scene, name: str) -> Obstacle:
    for obstacle in scene.obstacles:
        if obstacle.name == name:
            return obstacle
    held = " (it is carried: detach it first)" if name in {item.name for item in scene.carried} else ""
    if name in {item.name for item in scene.moving}:
        held = " (it follows a known motion: remove it and add it again)"
    names = choices(obstacle.name for obstacle in scene.obstacles)
    raise SceneError(f"obstacle '{name}' not found{held}; obstacles are {names}.")


def _find_carried(scene: Scene, name: str) -> Carried:
    for item in scene.carried:
        if item.name == name:
            return item
    raise SceneError(
        f"carried object '{name}' not found; the arm carries {choices(item.name for item in scene.carried)}."
    )
