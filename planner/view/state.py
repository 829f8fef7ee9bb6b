"""A robot at one configuration, checked before anything is planned: contacts, distances, w and limits."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats
from planner.collision.checker import CollisionChecker, contact_at
from planner.collision.recheck import Clearance
from planner.collision.world import Contact
from planner.kinematics.forward import tool_positions
from planner.kinematics.manipulability import manipulability, unit_of
from planner.query.resolve import beyond_limits
from planner.trajectory.measure import SHOWN, clearance_text
from planner.view.motion import ShownPath
from planner.view.page import Page


@dataclass(frozen=True, eq=False)
class StateReport:
    """Everything that the page shows about a configuration ``q`` (dof,) in a scene.

    ``contacts`` are all pairs no farther apart than the margin, ``clearance`` (m) is the distance of the nearest pair
    that some joint can part, inf where no pair is checked. ``outside`` names joints beyond a limit, ``tool`` is in m.
    """

    checker: CollisionChecker
    q: Floats
    contacts: tuple[Contact, ...]
    clearance: float
    w: float
    tool: Floats
    outside: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """Whether the robot could be here, and if not why."""
        problems = []
        for first in self.contacts[:1]:
            more = f" ({len(self.contacts)} pairs in all)" if len(self.contacts) > 1 else ""
            problems.append(f"{first} {first.how(self.checker.world.margin)}{more}")
        if self.outside:
            problems.append(f"out of limits: {', '.join(self.outside)}")
        if problems:
            return "; ".join(problems) + "."
        if self.clearance < SHOWN:
            return f"Within limits, and no contact was found; but the clearance is {clearance_text(self.clearance)}."
        return "Free and within limits."

    def page(self) -> str:
        """The page of the robot standing still; what touches is red."""
        robot, scene = self.checker.robot, self.checker.world.scene
        rows = [("contact", str(pair).replace("'", "")) for pair in self.contacts]
        if np.isfinite(self.clearance):
            touches = self.clearance == 0.0 and self.contacts
            rows.append(("clearance", "none" if touches else clearance_text(self.clearance)))
        rows.append(("w", f"{self.w:.3g} {unit_of(robot)}"))
        rows.append((f"{robot.tool} (m)", ", ".join(f"{value:z.3f}" for value in self.tool)))
        touching = {name for pair in self.contacts for name in (pair.first, pair.second)}
        page = Page(robot, scene, self.q, self.sentence, touching=touching, wrong=("contact", *self.outside))
        page.add_paths([ShownPath(self.q[None], rows)])
        return page.html()


def inspect_state(checker: CollisionChecker, q: Floats) -> StateReport:
    """Everything about the configuration ``q`` (dof,), which may touch anything and be out of any limit."""
    robot, beyond = checker.robot, beyond_limits(checker.robot, q) > 0
    return StateReport(
        checker,
        q,
        _contacts(checker, q),
        float(Clearance(checker)(q)[0]),
        float(manipulability(robot, q)[0]),
        tool_positions(robot, q)[0],
        tuple(joint for joint, out in zip(robot.joints, beyond, strict=True) if out),
    )


def _contacts(checker: CollisionChecker, q: Floats) -> tuple[Contact, ...]:
    """Every checked pair that touches or is closer than the margin; the one that the checker finds first leads."""
    first = contact_at(checker, q)
    if first is None:
        return ()
    world = checker.world
    scene = np.flatnonzero(world.checked.ravel())
    pairs = np.concatenate([scene, world.checked.size + np.arange(len(world.self_pairs))])
    near = pairs[checker.gaps(q, pairs) <= world.margin]
    return tuple(dict.fromkeys([first, *(world.contact(int(pair)) for pair in near)]))
