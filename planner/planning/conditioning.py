"""How well conditioned a path is where it is worst, and what to try where that is bad."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats, lengths_along
from planner.base.resolutions import W_ALONG_PATH
from planner.kinematics.manipulability import manipulability
from planner.problem.outcome import Record
from planner.problem.request import PlanQuality
from planner.roadmap.roadmap import Roadmap
from planner.robot.robot import Robot
from planner.search.manipulability_floor import highest_floor
from planner.search.network import build_network
from planner.trajectory.measure import dense_path

POOR = 0.1  # of the typical w: a path that falls below it is called badly conditioned
_BETTER = 1.2  # a floor is worth trying that is so much higher than the smallest w
_AT_END = 1.05  # the smallest w is an end's if the end's is no larger than so much of it


@dataclass(frozen=True, kw_only=True, eq=False)
class Conditioning(Record):
    """Where on the path w is smallest, against what is typical."""

    w_min: float
    typical: float
    """the median of w over the roadmap's nodes"""
    poor: bool
    share: float
    """of the path's length (rad), where w is smallest"""
    reachable_floor: float | None
    """the highest floor above which a path of the roadmap stays; null where the path is not poor"""
    advice: str | None
    """what to try; null where the path is not poor"""


def judge_conditioning(robot: Robot, roadmap: Roadmap, path: Floats, quality: PlanQuality) -> Conditioning:
    """The judgement on a path (k, dof) of ``roadmap``, sampled ``W_ALONG_PATH`` apart, of a plan of ``quality``."""
    q = dense_path(path, W_ALONG_PATH)
    w, typical = manipulability(robot, q), float(np.median(roadmap.manipulability))
    lowest = int(w.argmin())
    w_min, poor = float(w[lowest]), bool(w[lowest] < POOR * typical)
    along = lengths_along(q)
    share = float(along[lowest] / along[-1]) if along[-1] > 0 else 0.0
    floor = highest_floor(robot, roadmap, build_network(roadmap, quality.objective)) if poor else None
    found = Conditioning(
        w_min=w_min,
        typical=typical,
        poor=poor,
        share=share,
        reachable_floor=floor,
        advice=None,
    )
    return replace(found, advice=_advice(found, w[[0, -1]], quality)) if poor else found


def _advice(found: Conditioning, ends: Floats, quality: PlanQuality) -> str:
    """What is bad about a poor path whose ends have the w ``ends`` (2,), and what to try."""
    at_ends = [end for end, w in zip(("start", "goal"), ends, strict=True) if w <= _AT_END * found.w_min]
    where = f"at the {at_ends[0]} itself" if at_ends else f"at {100 * found.share:.0f} % of the path"
    percent = 100 * found.w_min / found.typical
    tries, floor = [], found.reachable_floor or 0.0
    if floor > _BETTER * max(found.w_min, quality.min_manipulability):
        tries.append(f"--min-manipulability {floor:g}, above which a path of this roadmap stays")
    if quality.beta == 1.0:
        tries.append("a --beta below 1")
    elif quality.charge == "nodes":
        tries.append("--charge edges")
    if not tries:
        tries = [f"another {at_ends[0]}"] if at_ends else ["more --nodes", "another --seed"]
    return (
        f"Badly conditioned {where}: w {found.w_min:.2g} there is {percent:.2g} % of the roadmap's median "
        f"{found.typical:.2g}. Try {'; or '.join(tries)}."
    )
