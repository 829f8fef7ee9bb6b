"""Which step of a task fails, and why, as data."""

from __future__ import annotations

from copy import deepcopy

import numpy as np

from planner.kinematics.inverse import beyond_reach
from planner.tasks.file import Move, Pick, Step
from planner.tasks.options import Options, Tried
from planner.tasks.record import StepFails
from planner.tasks.search import LazySearch

_WORTH_SAYING = 5e-3  # m


def doing(step: Step) -> str:
    """A step in words."""
    return f"move to {step.to}" if isinstance(step, Move) else f"{type(step).__name__.lower()} {step.object}"


def why_stuck(options: Options, search: LazySearch | None) -> StepFails:
    """The first step without options, or the one that no path gets beyond."""
    dead = options.dead_end
    number = dead if dead is not None else search.reached() if search is not None else 0
    number = min(number, len(options.task.steps) - 1)
    step, tried = options.task.steps[number], deepcopy(options.tried[number])
    lost = search is not None and not isinstance(step, Move) and _all_blocked(options, search, number, tried)
    what = "no_path"
    if dead is not None or lost:
        what = "no_grasp" if isinstance(step, Pick) else "no_placement"
    return StepFails(
        step=number + 1,
        doing=doing(step),
        what=what,
        tried=tried.of,
        out_of_reach=len(tried.out_of_reach),
        strays=tried.strays,
        contacts=dict(tried.contacts.most_common()),
        conditions=options.modes.checker.world.keeps.texts,
        beyond=_beyond(options, tried),
    )


def _beyond(options: Options, tried: Tried) -> float | None:
    """How far (m) the nearest is proven beyond reach; None where not all are."""
    if len(tried.out_of_reach) < tried.of or not tried.of:
        return None
    nearest = min(beyond_reach(options.modes.robot, position) for position in tried.out_of_reach)
    return nearest if nearest >= _WORTH_SAYING else None


def _all_blocked(options: Options, search: LazySearch, number: int, tried: Tried) -> bool:
    """Whether the lines of every option of a step are refused in every mode; what they touch is counted."""
    net, hits, left = search.network, [], False
    whole = net.at(0.5)
    for way in (way for way in net.ways if way.step == number):
        arcs = whole.arcs_along(np.arange(way.first, way.last + 1))
        refused = arcs[search.refused[arcs]].tolist()
        left = left or not refused
        why = (options.modes.why(net.modes[net.mode[arc]], int(net.motion[arc])) for arc in refused)
        hits.append((way.option, next((hit for hit in why if hit), None)))
    tried.count_blocked(hits)
    return bool(hits) and not left
