"""The rows of ``benchmarks first-motion``, and the table of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

from benchmarks.bench import aim_lines, closing_lines
from planner.base.tables import markdown_table, median, percentile
from planner.batch.outcomes import SOLVED
from reproduce.verdict import Verdict, tally

OURS, WHOLE, OMPL, ROBOPLAN = "planner", "planner, whole roadmap", "OMPL RRTConnect, plain coal", "roboplan"
OTHERS = (ROBOPLAN, "pyroboplan", "hpp")
_STAGES = ("ready_s", "first_s", "path_s", "motion_s", "total_s")
_GOALS = (("ready_s", 0.006, "ready"), ("path_s", 0.015, "a path"), ("motion_s", 0.012, "a motion along it"))
_TOTAL, _LATE, _SHARE_LATE, _DURATION = 0.035, 0.081, 98.0, 1.25  # s, s, %, s
_WHOLE = 0.5  # s


@dataclass(frozen=True)
class Row:
    """One problem by one method. Up to ``software``: what was asked; then the results, None where there are none.

    ``limits``: of the motion, in words; ``content``: a hash of the problem's files. Seconds of the wall clock, robot,
    scene and states in memory: ``ready_s`` from a new scene to a checker, then ``first_s`` to a path, ``path_s`` to the
    path after shortcuts, ``motion_s`` from there to the motion, ``total_s`` all together; ``cpu_s`` of the processor,
    where it was measured. ``duration_s``: of the motion. ``proven``: as a whole, by the method itself. ``contacts``:
    segments of the path on which the library that has not planned finds a contact when it looks at every millimetre of
    motion; ``message``: the first of them. ``motion_contact``: the first that it sees at 0.1 mm along the motion.
    ``largest_share`` of any limit that the method knows, 1 is all of it.
    """

    problem: str
    method: str
    seed: int
    robot: str
    collision: str
    limits: str
    seconds: float
    content: str
    software: str
    outcome: str
    message: str = ""
    version: str | None = None
    ready_s: float | None = None
    first_s: float | None = None
    path_s: float | None = None
    motion_s: float | None = None
    total_s: float | None = None
    cpu_s: float | None = None
    duration_s: float | None = None
    length_rad: float | None = None
    corners: int | None = None
    proven: bool | None = None
    contacts: int | None = None
    motion_contact: str = ""
    largest_share: float | None = None

    @property
    def key(self) -> tuple:
        """What was asked."""
        asked = self.seed, self.robot, self.collision, self.limits, self.seconds, self.content, self.software
        return (self.problem, self.method, *asked)


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The report for people."""
    methods = dict.fromkeys(row.method for row in rows)
    lines = [_cells(method, _of(rows, method)) for method in methods]
    limits = "; ".join(dict.fromkeys(row.limits for row in rows))
    text = ["# python -m benchmarks first-motion", "", *markdown_table(_HEADER, lines), ""]
    text += [*aim_lines(aims(rows)), "", *_ratios(rows), ""]
    text += [f"- {row.problem}, {row.method}: {row.outcome}. {row.message}" for row in rows if row.outcome != SOLVED]
    text += [f"- {row.problem}, {row.method} touches: {row.message}." for row in rows if row.contacts]
    text += [f"- {row.problem}, motion of {row.method} touches: {row.motion_contact}." for row in rows if _bumps(row)]
    return "\n".join([*text, "", f"Limits: {limits}.", *closing_lines(rows, complete, "runs", _METHOD)]) + "\n"


def _ratios(rows: Sequence[Row]) -> list[str]:
    """How our times compare with those of the other methods, problem by problem: the same on slower machines."""
    lines = []
    for method in dict.fromkeys(row.method for row in rows if row.method not in (OURS, WHOLE)):
        for name, what in (("path_s", "A path after shortcuts"), ("total_s", "From problem to motion")):
            shares = [own / other for own, other in _both(rows, method, name)]
            if (middle := median(shares)) is not None:
                lines.append(f"- {what}: {middle:.2f} of {method}'s time, in the median of {len(shares)} problems.")
    return lines


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What is meant to hold; of 0 where nothing was measured."""
    ours = [row for row in rows if row.method in (OURS, WHOLE)]
    solved = [row for row in ours if row.outcome == SOLVED]
    timed, whole = _of(solved, OURS), _of(solved, WHOLE)
    late = percentile((row.total_s for row in timed), _SHARE_LATE)
    beside = _durations_beside(rows)
    return (
        tally("We solve every problem.", (row.outcome == SOLVED for row in ours), ""),
        tally("No path of ours touches anything.", (row.contacts == 0 for row in solved), ""),
        tally("No motion of ours touches anything.", (not row.motion_contact for row in solved), ""),
        tally("Every motion of ours is proven as a whole.", (bool(row.proven) for row in solved), ""),
        tally("No motion of ours exceeds a limit.", (_within(row) for row in solved), ""),
        *(_quick(f"In the median {what} takes {most:g} s or less.", timed, name, most) for name, most, what in _GOALS),
        _quick(f"From problem to motion it is {_TOTAL:g} s or less in the median.", timed, "total_s", _TOTAL),
        _at_most(f"It is {_LATE:g} s or less in {_SHARE_LATE:g} %.", late, _LATE),
        _quick(f"With the whole roadmap, refined, it is {_WHOLE:g} s or less in the median.", whole, "total_s", _WHOLE),
        _at_most(f"Motions take {_DURATION:g} s or less in the mean.", _mean(timed), _DURATION),
        _at_most("They are no longer than roboplan's on the same problems, in the mean.", *beside),
    )


def _quick(sentence: str, rows: Sequence[Row], name: str, most: float) -> Verdict:
    return _at_most(sentence, median(getattr(row, name) for row in rows), most)


def _at_most(sentence: str, value: float | None, most: float | None) -> Verdict:
    if value is None or most is None:
        return tally(sentence, [], "")
    return tally(sentence, [value <= most], f"{value:.3g} s, {most:.3g} s at most.")


def _within(row: Row) -> bool:
    return row.largest_share is not None and row.largest_share <= 1.0


def _bumps(row: Row) -> bool:
    return bool(row.motion_contact)


def _of(rows: Sequence[Row], method: str) -> list[Row]:
    return [row for row in rows if row.method == method]


def _mean(rows: Sequence[Row]) -> float | None:
    there = [row.duration_s for row in rows if row.duration_s is not None]
    return fmean(there) if there else None


def _both(rows: Sequence[Row], method: str, name: str) -> list[tuple[float, float]]:
    """A field of our rows and of another method's, by its ``name``: of each problem that both solved and have it."""
    solved = [row for row in rows if row.outcome == SOLVED]
    ours, other = (
        {row.problem: value for row in _of(solved, each) if (value := getattr(row, name))} for each in (OURS, method)
    )
    return [(ours[problem], other[problem]) for problem in sorted(ours.keys() & other.keys())]


def _durations_beside(rows: Sequence[Row]) -> tuple[float | None, float | None]:
    """Mean durations of ours and roboplan's over what both have timed."""
    both = _both(rows, ROBOPLAN, "duration_s")
    return (fmean(own for own, _ in both), fmean(other for _, other in both)) if both else (None, None)


_HEADER = ["method", "solved", "of", "ready (s)", "first path (s)", "after shortcuts (s)", "motion (s)", "total (s)"]
_HEADER += ["98 % (s)", "CPU (s)", "motion takes (s)", "length (rad)", "corners", "proven", "paths touching"]
_HEADER += ["motions touching", "largest share"]


def _cells(method: str, rows: Sequence[Row]) -> list[Any]:
    """A line of medians over the solved problems; 98 % of the whole, where there is a motion, else to the path."""
    solved = [row for row in rows if row.outcome == SOLVED]
    version = next((f" {row.version}" for row in solved if row.version), "")
    middle = [median(getattr(row, name) for row in solved) for name in _STAGES]
    late = percentile((row.path_s if row.total_s is None else row.total_s for row in solved), _SHARE_LATE)
    rest = [median(getattr(row, name) for row in solved) for name in ("length_rad", "corners")]
    timed = [row for row in solved if row.duration_s is not None]
    most = max((row.largest_share for row in timed if row.largest_share is not None), default=None)
    cells = [method + version, len(solved), len(rows), *middle, late, median(row.cpu_s for row in solved), _mean(timed)]
    cells += [*rest, _share([bool(row.proven) for row in solved]), _share([bool(row.contacts) for row in solved])]
    return [*cells, _share([_bumps(row) for row in timed]), most]


def _share(found: Sequence[bool]) -> str | None:
    return f"{sum(found)} of {len(found)}" if found else None


_METHOD = """How. Every run has a process of its own, one after the other; libraries are loaded, and the robot, before
the clocks start. Times are medians of the wall clock over the problems that the method solved, the duration of motions
is a mean; ready is from a new scene to a checker of it, shortcuts count from the same moment as the first path, 98 % is
of the total, or of the time to the path where there is no motion. Ours: `planner plan --path-only` without its page,
every motion proven, after a plan of the same robot in an empty scene; with the whole roadmap, a plan whose path is
there once all is refined. Before ours and OMPL's Python collects what loading left behind, 0.03 s that would fall on
one plan of a process. OMPL: RRTConnect and `simplifyMax` with its defaults, a Python callback that asks Pinocchio
and coal about all pairs. roboplan (C++) and pyroboplan (Python): RRT-Connect and their own shortcuts, states 0.05 rad
apart, in the environments given by `--python NAME=PATH`, with the same URDF, limits, link pairs and obstacles;
roboplan's connection distance is its default, 3 rad, pyroboplan's 1 rad. roboplan's motion is that of its default
spline and TOPP-RA, whose samples a controller makes cubics of; it knows no limits on jerk, so its share is that of
velocity and acceleration. Shares are of exact extrema of the pieces between knots. hpp: BiRRTPlanner and
RandomShortcut, every motion proven by its continuous validation (Dichotomy, no tolerance); its seed cannot be set, and
its motions are not timed here. Of several goals the first is asked for. Touching: the collision library that we have
not planned with looks at every millimetre of the path, and every 0.1 mm of the motion.
Limitations. The others stop by the clock: on a loaded machine they solve fewer problems. Only boxes, spheres and
cylinders can be told to all. A path that is not proven can touch less, or more, than this look sees."""
