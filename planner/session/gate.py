"""The gate between whoever decides what a robot does next and the robot."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from planner.base.arrays import Floats, numbers
from planner.base.errors import StateError
from planner.base.yamlfile import FARTHEST
from planner.collision.checker import CollisionChecker
from planner.problem.options import Backend, RobotLike, conditions_of
from planner.problem.request import LimitsRequest, WorldRequest
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Obstacle
from planner.session.chunk import RobotState, Row, Rows
from planner.session.guard import Guard
from planner.session.judging import judge
from planner.session.live_world import LiveWorld
from planner.session.rules import JUDGED, Rules
from planner.session.verdict import Verdict
from planner.trajectory.limits import MotionLimits, own_limits


class Gate:
    """Says whether what a robot is about to do is proven safe, and until when; half a millisecond a chunk.

        gate = planner.Gate("panda", "shelf", margin=0.01)
        verdict = gate.check(targets, times=[0.1, 0.2, 0.3], state=(q, qd))
        verdict.safe, verdict.safe_until, verdict.reason, verdict.stop

    ``robot`` and ``scene`` by name, file or as loaded. ``limits``: the robot's own where left out; ``judged`` are those
    that are asked for, of position, velocity, acceleration and jerk. ``min_manipulability`` is kept by all that is run,
    stops too, and so is what the scene and ``keep`` say. ``margin`` (m) is kept to everything; a larger one refuses
    more. A first point at 0 s may be ``start_tolerance`` (rad, m, these per s and s²) from the robot's state. A check
    changes nothing: several threads may check at once, also while another changes the world. Raises
    :class:`PlannerError` for what cannot be loaded, and where obstacles move along known motions.
    """

    def __init__(
        self,
        robot: RobotLike = "iiwa14",
        scene: RobotLike = "paper",
        limits: MotionLimits | LimitsRequest | None = None,
        *,
        judged: Sequence[str] = JUDGED,
        min_manipulability: float = 0.0,
        margin: float = 0.0,
        start_tolerance: float = 0.01,
        tool: str | None = None,
        collision: Backend = "fcl",
        keep: object = (),
    ) -> None:
        self._changing = threading.Lock()
        request = WorldRequest(
            robot=robot, scene=scene, margin=margin, tool=tool, collision=collision, keep=conditions_of(keep)
        )
        self._live = LiveWorld.of(request)
        robot = self._live.checker.robot
        kept = limits if isinstance(limits, MotionLimits) else MotionLimits.of(robot, limits)
        self._limits = own_limits(kept, robot)
        self._rules = Rules.of(robot, kept, judged, min_manipulability, start_tolerance)
        self._guard = Guard.of(self._live.checker, self._rules)
        self.checker.make_ready()  # its trees of triangles: no check waits for them

    def __repr__(self) -> str:
        return f"<Gate: {self.robot.name} in {self.scene.name}>"

    @property
    def robot(self) -> Robot:
        """The robot with what it carries now."""
        return self._guard.checker.robot

    @property
    def scene(self) -> Scene:
        """The scene as it is now, with what the arm carries."""
        return self._guard.checker.world.scene

    @property
    def checker(self) -> CollisionChecker:
        """The checker of the world as it is now."""
        return self._guard.checker

    def to_dict(self) -> dict[str, Any]:
        """What is judged, as plain data, and the revision of the world."""
        return {"limits": self.limits.to_dict(), **self._guard.to_dict()}

    @property
    def limits(self) -> MotionLimits:
        """The limits that are kept, as far as they are judged."""
        return self._limits

    def __reduce__(self) -> NoReturn:
        raise TypeError("a gate stays in its process and is no copy of another: make one of its robot and scene.")

    def check(
        self,
        positions: Rows,
        velocities: Rows | None = None,
        accelerations: Rows | None = None,
        *,
        times: Row,
        state: RobotState | None = None,
        stop: bool = True,
    ) -> Verdict:
        """Whether targets (k, dof), rad (m) in the robot's order of joints, at ``times`` (k,) s after now, are safe.

        Proven is what joint_trajectory_controller runs: lines where only positions are given, cubics with velocities,
        quintics with accelerations too, from ``state`` = (q, qd) or (q, qd, qdd), (dof,) each, on; from the first point
        on where no state is given. With ``stop`` a stop is proven from every point, too. What is not decided is not
        safe. Raises :class:`ArrayError` for other shapes, NaN, times that do not increase, and no points,
        :class:`StateError` for a state outside limits; the gate goes on.
        """
        return judge(self._guard, (positions, velocities, accelerations, times, state), stop)

    def move(self, name: str, pose: Floats) -> None:
        """Put the obstacle ``name`` to another ``pose`` (4, 4), as :func:`planner.pose` makes it."""
        self._change(lambda live: live.put(name, pose))

    def add(self, obstacle: Obstacle) -> None:
        """Put an obstacle into the world."""
        self._change(lambda live: live.add(obstacle))

    def remove(self, name: str) -> None:
        """Take the obstacle ``name`` out of the world."""
        self._change(lambda live: live.remove(name))

    def attach(self, name: str, frame: str, at: Row, touch_links: Sequence[str] = ()) -> None:
        """Let ``frame`` carry the obstacle ``name`` as it stands to it in the configuration ``at`` (dof,).

        It may touch ``touch_links`` and the link itself.
        """
        q = self._configuration(at)
        self._change(lambda live: live.attach(name, frame, tuple(touch_links), q))

    def detach(self, name: str, at: Row) -> None:
        """Put down what the arm carries where it holds it in the configuration ``at`` (dof,).

        What might touch it in the hold still may, as it does when it is let go of: remove it and add it to forbid that.
        """
        q = self._configuration(at)
        self._change(lambda live: live.detach(name, q))

    def _configuration(self, at: Row) -> Floats:
        return numbers("at", at, (self.robot.dof,), StateError, FARTHEST)

    def _change(self, apply: Callable[[LiveWorld], LiveWorld]) -> None:
        """A new world, or an error and the old one."""
        with self._changing:
            live = apply(self._live)
            self._guard, self._live = Guard.of(live.checker, self._rules), live
