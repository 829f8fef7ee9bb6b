"""The report on a robot at one configuration: contacts, distances, w and limits."""

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
    """The report on a configuration ``q`` (dof,) in a scene.

    ``contacts`` are all pairs within the margin, ``clearance`` (m) is the distance of the nearest pair that some joint
    can part, inf if no pair is checked. ``outside`` names joints beyond a limit, ``tool`` is in m.
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
        """The verdict on the configuration, with the reasons against it."""
        problems = []
        for first in self.contacts[:1]:
            more = f" ({len(self.contacts)} pairs in all)" if len(self.contacts) > 1 else ""
            problems.append(f"{first} {first.how(self.checker.world.margin)}{more}")
        if self.outside:
            problems.append(f"out of limits: {', '.join(self.outside)}")
        if problems:
            return "; ".join(problems) + "."
        if self.clearance < SHOWN:
            return f"Within limits and without contact; but the clearance is {clearance_text(self.clearance)}."
        return "Free and within limits."

    def page(self) -> str:
        """Return the page of the robot at rest; bodies in contact are red."""
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
    """Return the report on the configuration ``q`` (dof,), which may touch anything and exceed any limit."""
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
    """Return every checked pair within the margin; the checker's first one leads."""
    first = contact_at(checker, q)
    if first is None:
        return ()
    world = checker.world
    scene = np.flatnonzero(world.checked.ravel())
    pairs = np.concatenate([scene, world.checked.size + np.arange(len(world.self_pairs))])
    near = pairs[checker.gaps(q, pairs) <= world.margin]
    return tuple(dict.fromkeys([first, *(world.contact(int(pair)) for pair in near)]))
