"""Why there is no path, or no usable start or goal: each reason as data, and as a sentence."""

from __future__ import annotations

from dataclasses import dataclass

from planner.base.errors import Reason, choices
from planner.problem.conditions import parse_condition


@dataclass(frozen=True)
class Touching(Reason):
    """Two things touch, or come closer than the margin, where ``role`` ("start", "goal", "world") puts the robot.

    ``enclosed``: one lies wholly inside the other.
    """

    role: str
    first: str
    second: str
    enclosed: bool
    kind = "touching"

    @property
    def names(self) -> frozenset[str]:
        return frozenset((self.first, self.second))


@dataclass(frozen=True)
class BeyondLimit(Reason):
    """``role`` puts a joint at ``value``, outside [``lower``, ``upper``]: rad, or m where it slides."""

    role: str
    joint: str
    value: float
    lower: float
    upper: float
    kind = "beyond_limit"


@dataclass(frozen=True)
class BreaksKept(Reason):
    """``role`` lies outside what is to be kept, the ``condition`` in its text, by so much: rad, or m."""

    role: str
    condition: str
    by: float
    kind = "breaks_kept"


@dataclass(frozen=True)
class OutOfReach(Reason):
    """No configuration brings the tool to ``role``: the nearest found stays ``distance`` (m) away."""

    role: str
    distance: float
    kind = "out_of_reach"


@dataclass(frozen=True)
class Gap:
    """How near the parts of a roadmap came that hold start and goal: the shortest straight motion between them.

    ``joint_distance`` (rad) from the configuration ``start_side`` to ``goal_side``, and the two things ``between`` that
    stop it; None where none was found, as where manipulability forbids it.
    """

    joint_distance: float
    start_side: tuple[float, ...]
    goal_side: tuple[float, ...]
    between: tuple[str, str] | None

    @property
    def sentence(self) -> str:
        stop = f", where '{self.between[0]}' and '{self.between[1]}' come too near" if self.between else ""
        return f"their parts of the roadmap came within {self.joint_distance:.3g} rad of each other{stop}"


@dataclass(frozen=True)
class Separated(Reason):
    """Without ``obstacles`` start and goal would be joined; no smaller set was found that does as much."""

    obstacles: tuple[str, ...]
    gap: Gap
    kind = "separated"

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.obstacles)

    @property
    def sentence(self) -> str:
        """What the user reads."""
        named = choices(f"'{name}'" for name in self.obstacles)
        one = len(self.obstacles) == 1
        return (
            f"Start and goal were not connected within the budget: the search found that {named} "
            f"{'separates' if one else 'together separate'} them (without {'it' if one else 'them'} they are joined), "
            f"and {self.gap.sentence}: move {'it' if one else 'one of them'}, raise --nodes, or try another --seed."
        )


@dataclass(frozen=True)
class BudgetSpent(Reason):
    """``nodes`` and a bounded search did not join start and goal, and no obstacle was found that separates them."""

    nodes: int
    gap: Gap
    kind = "budget_spent"

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.gap.between or ())

    @property
    def sentence(self) -> str:
        """What the user reads."""
        return (
            f"Start and goal were not connected within the budget of {self.nodes} nodes: {self.gap.sentence}; no "
            "obstacle was found without which they are joined: raise --nodes, or try another --seed."
        )


@dataclass(frozen=True)
class FloorTooHigh(Reason):
    """No path keeps to the floor ``asked`` (w); ``reachable`` is the highest floor found that a path keeps to."""

    asked: float
    reachable: float
    kind = "floor_too_high"

    @property
    def sentence(self) -> str:
        """What the user reads."""
        head = f"No path above the manipulability floor of {self.asked:g} was found within the budget: "
        if self.reachable <= 0:
            return head + "all paths that were found pass through w = 0 or near it: leave --min-manipulability out."
        return head + (
            f"the highest floor that a path on a small roadmap keeps to is {self.reachable:g}: take "
            f"--min-manipulability {self.reachable:g} or less, raise --nodes, or try another --seed."
        )


@dataclass(frozen=True)
class KeptTooNarrow(Reason):
    """Start and goal are joined where nothing is kept, but by no path that was found to keep the ``conditions``."""

    conditions: tuple[str, ...]
    gap: Gap
    kind = "kept_too_narrow"

    @property
    def sentence(self) -> str:
        """What the user reads."""
        kept = choices(f"'{text}'" for text in self.conditions)
        return (
            f"No path that keeps {kept} was found within the budget; without that start and goal are joined, and with "
            f"it {self.gap.sentence}: leave more tolerance, raise --nodes, or try another --seed."
        )


@dataclass(frozen=True)
class BlockedInTime(Reason):
    """Start and goal are joined, but no motion in time keeps clear of ``obstacles``, which move along known motions.

    ``place``: "start", where the arm is not clear of them at time 0; "goal", where it cannot stay for good; "route",
    where without them there is a motion, as far as that was found. None of them can be put back.
    """

    place: str
    obstacles: tuple[str, ...]
    kind = "blocked_in_time"

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.obstacles)

    @property
    def sentence(self) -> str:
        """What the user reads."""
        named, head = choices(f"'{name}'" for name in self.obstacles), "Start and goal are joined, but not in time: "
        if self.place == "start":
            return head + f"at time 0 {named} cannot be proven clear of the arm at the start: choose another start."
        if self.place == "goal":
            come = "comes" if len(self.obstacles) == 1 else "come"
            return head + f"the arm cannot stay at the goal, where {named} {come} too near: choose another goal."
        return head + (
            f"no motion through the roadmap was found that keeps clear of {named}, waiting included: "
            "raise --nodes, or try another --seed."
        )


@dataclass(frozen=True)
class CannotFollow(Reason):
    """A tool path cannot be followed to ``point`` (from 1), but for a share ``followed`` of its length; ``cause`` why.

    "out_of_reach": inverse kinematics came no nearer than ``distance`` (m); "turned": it misses the orientation by
    ``distance`` (rad); "beyond_limit": only beyond the limits of joints, the ``between``; "touching": all solutions
    touch, most of them the two things ``between``; "strays": all break what is to be kept, the condition ``between``
    by ``distance`` (m, rad) at least; "below_floor": the floor is too high, ``reachable`` the highest
    found with which it goes on; "jump": the solutions there are on other branches, ``distance`` (rad) away at least.
    ``cone``: the narrowest about the axis (rad) that was found to let it there; 0 where a free turn will do.
    ``leg``: "approach" or "retreat", where it is one of a plan's, point 1 its start or goal.
    """

    point: int
    followed: float
    cause: str
    distance: float = 0.0
    between: tuple[str, ...] = ()
    reachable: float = 0.0
    leg: str = ""
    cone: float | None = None
    kind = "cannot_follow"

    @property
    def _remedy(self) -> str:
        """What to do where the tool cannot be there, or so."""
        if self.leg:
            return f"shorten it, or choose another {'goal' if self.leg == 'approach' else 'start'}"
        ways = []
        if self.cone is not None:
            ways += [f"give a cone of {self.cone:g} rad about its axis" if self.cone else "let it turn about its axis"]
        return " or ".join(ways) or "move the path or the robot's base"

    @property
    def names(self) -> frozenset[str]:
        return frozenset(self.between if self.cause == "touching" else ())

    @property
    def sentence(self) -> str:
        """What the user reads."""
        head = f"The tool path can be followed over {100 * self.followed:.1f} %, not to point {self.point}: "
        if self.leg:
            head = f"The {self.leg} goes over {100 * self.followed:.1f} % of its length, seen from its end: "
        match self.cause:
            case "out_of_reach":
                return head + f"the tool comes no nearer than {self.distance:.3g} m; {self._remedy}."
            case "turned":
                return head + f"the tool stays turned away by {self.distance:.3g} rad; {self._remedy}."
            case "beyond_limit":
                return head + f"the arm would have to leave the limits of {choices(self.between)}; {self._remedy}."
            case "touching":
                first, second = (f"'{name}'" for name in self.between)
                return (
                    head + f"{first} and {second} come too near in all solutions found; move the path or what is near."
                )
            case "strays":
                unit = parse_condition(self.between[0]).unit
                return (
                    head + f"'{self.between[0]}', which is to be kept, would be broken by {self.distance:.3g} {unit}; "
                    "move the path, or keep less."
                )
            case "below_floor":
                return (
                    head
                    + f"the floor is too high, the highest found that it keeps to is {self.reachable:g}; take that."
                )
        return head + (
            f"what was reached and the solutions there are {self.distance:.3g} rad apart, on other branches or with "
            "something between; free the tool's axis, widen the tube, "
            "or split the path there."
        )


NoWay = Separated | BudgetSpent | KeptTooNarrow
"""Start and goal lie in different parts of the roadmap."""

NoPath = NoWay | FloorTooHigh | BlockedInTime | CannotFollow
