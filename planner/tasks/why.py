"""Which step of a task fails, and why, as data."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass

from planner.base.errors import Reason, choices
from planner.kinematics.inverse import beyond_reach
from planner.tasks.file import Move, Pick, Step
from planner.tasks.options import Options, Tried
from planner.tasks.search import LazySearch

_NAMED = 3  # contacts in the sentence
_WORTH_SAYING = 5e-3  # m


@dataclass(frozen=True)
class StepFails(Reason):
    """The first ``step`` (from 1) that cannot be done, ``doing`` what, and ``what`` is missing.

    Of ``tried`` grasps, or pairs of a grasp and a placement, so many are ``out_of_reach``; ``contacts`` is how often
    two things were the first that touch where all configurations of one were in contact, and so many of one ``strays``
    from the ``conditions`` that all motions keep. ``beyond``: how far (m) the nearest is beyond where the arm can ever
    bring the tool, where all are: as much nearer is the least that could work. ``no_path``: some can be reached, but no
    path leads there.
    """

    step: int
    doing: str
    what: str  # no_grasp, no_placement or no_path
    tried: int
    out_of_reach: int
    strays: int
    contacts: dict[str, int]
    conditions: tuple[str, ...] = ()
    beyond: float | None = None
    kind = "step_fails"

    @property
    def names(self) -> frozenset[str]:
        return frozenset(part.strip("'") for pair in self.contacts for part in pair.split("' and '"))

    @property
    def sentence(self) -> str:
        """What the user reads."""
        head = f"Step {self.step} ({self.doing}) cannot be done: "
        found = f"{self.out_of_reach} of {self.tried} out of reach"
        found += f" (the nearest by {self.beyond:.2f} m or more)" if self.beyond else ""
        for pair, count in list(self.contacts.items())[:_NAMED]:
            found += f", {count} in contact ({pair})"
        if self.strays:
            found += f", {self.strays} straying from what is kept ({choices(self.conditions)})"
        less = ", or keep less" if self.strays else ""
        match self.what:
            case "no_grasp":
                return f"{head}no grasp is left, {found}: move the object or the robot, or give other grasps{less}."
            case "no_placement":
                return f"{head}no placement is left, {found}: give another region, or more samples{less}."
        seen = f" ({found})" if self.tried else ""
        return f"{head}no path leads there within the budget{seen}: raise --nodes, or try another --seed."


def doing(step: Step) -> str:
    """A step in words."""
    return f"move to {step.to}" if isinstance(step, Move) else f"{type(step).__name__.lower()} {step.object}"


def why_stuck(options: Options, search: LazySearch | None) -> StepFails:
    """The first step without options, or the one that no path gets beyond."""
    dead = options.dead_end
    number = dead if dead is not None else search.reached() if search is not None else 0
    number = min(number, len(options.task.steps) - 1)
    step, tried = options.task.steps[number], options.tried[number]
    tried = deepcopy(tried)
    lost = search is not None and not isinstance(step, Move) and _all_blocked(options, search, number, tried)
    what = "no_path"
    if dead is not None or lost:
        what = "no_grasp" if isinstance(step, Pick) else "no_placement"
    kept = options.modes.checker.world.keeps.texts
    contacts = dict(tried.contacts.most_common())
    counts = tried.of, tried.out_of_reach, tried.strays, contacts
    return StepFails(number + 1, doing(step), what, *counts, kept, _beyond(options, tried))


def _beyond(options: Options, tried: Tried) -> float | None:
    """How far (m) the nearest is proven beyond reach; None where not all are."""
    if tried.out_of_reach < tried.of or not tried.unreached:
        return None
    nearest = min(beyond_reach(options.modes.robot, position) for position in tried.unreached)
    return nearest if nearest >= _WORTH_SAYING else None


def _all_blocked(options: Options, search: LazySearch, number: int, tried: Tried) -> bool:
    """Whether the lines of every option of a step are refused in every mode; what they touch is counted."""
    net, modes = search.network, options.modes
    ways = [way for way in net.ways if way.step == number and way.option is not None]
    left = False
    for way in ways:
        arcs = [net.arc(way.first + k, way.first + k + 1) for k in range(3)]
        refused = [arc for arc in arcs if search.refused[arc]]
        left = left or not refused
        tried.blame(next((modes.why(net.modes[net.mode[arc]], int(net.motion[arc])) for arc in refused), None))
    return bool(ways) and not left
