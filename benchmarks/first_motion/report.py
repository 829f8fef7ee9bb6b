"""The rows of ``benchmarks first-motion``, and their report.

Columns. One problem by one method. Up to ``software``: what was asked; then the results, None where there are none.

``limits``: of the motion, in words; ``content``: a hash of the problem's files. Seconds of the wall clock, robot, scene
and states in memory: ``ready_s`` from a new scene to a checker, then ``first_s`` to a path, ``path_s`` to the path
after shortcuts, ``motion_s`` from there to the motion, ``total_s`` all together; ``cpu_s`` of the processor, where it
was measured. ``duration_s``: of the motion. ``proven``: as a whole, by the method itself. ``contacts``: segments of the
path on which the library that has not planned finds a contact when it looks at every millimetre of motion; ``message``:
the first of them. ``motion_contact``: the first that it sees at 0.1 mm along the motion. ``largest_share`` of any limit
that the method knows, 1 is all of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean

from benchmarks import bench
from benchmarks.others.elsewhere import ROBOPLAN
from benchmarks.text import median, percentile
from planner.batch.run import SOLVED

OURS, WHOLE, OMPL = "planner", "planner, whole roadmap", "OMPL RRTConnect, plain coal"
_GOALS = (("ready_s", 0.006, "ready"), ("path_s", 0.015, "a path"), ("motion_s", 0.012, "a motion along it"))
_TOTAL, _LATE, _SHARE_LATE, _DURATION = 0.035, 0.081, 98.0, 1.25  # s, s, %, s
_WHOLE = 0.5  # s


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """A line per method, and the ratios of our times."""
    limits = "; ".join(dict.fromkeys(row.limits for row in rows))
    return [*bench.table(rows, ["method"], _TABLE), *_ratios(rows), "", f"Limits: {limits}."]


def _ratios(rows: Sequence[bench.Row]) -> list[str]:
    """How our times compare with those of the other methods, problem by problem: the same on slower machines."""
    lines = []
    for method in dict.fromkeys(row.method for row in rows if row.method not in (OURS, WHOLE)):
        for name, what in (("path_s", "A path after shortcuts"), ("total_s", "From problem to motion")):
            shares = [own / other for own, other in _both(rows, method, name)]
            if (middle := median(shares)) is not None:
                lines.append(f"- {what}: {middle:.2f} of {method}'s time, in the median of {len(shares)} problems.")
    return lines


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """What is meant to hold; of 0 where nothing was measured."""
    ours = [row for row in rows if row.method in (OURS, WHOLE)]
    solved = [row for row in ours if row.outcome == SOLVED]
    timed, whole = _of(solved, OURS), _of(solved, WHOLE)
    late = percentile((row.total_s for row in timed), _SHARE_LATE)
    durations = _mean_durations(rows)
    return (
        bench.tally("We solve every problem.", (row.outcome == SOLVED for row in ours), ""),
        bench.tally("No path of ours touches anything.", (row.contacts == 0 for row in solved), ""),
        bench.tally("No motion of ours touches anything.", (not row.motion_contact for row in solved), ""),
        bench.tally("Every motion of ours is proven as a whole.", (bool(row.proven) for row in solved), ""),
        bench.tally("No motion of ours exceeds a limit.", (_within(row) for row in solved), ""),
        *(_quick(f"In the median {what} takes {most:g} s or less.", timed, name, most) for name, most, what in _GOALS),
        _quick(f"From problem to motion it is {_TOTAL:g} s or less in the median.", timed, "total_s", _TOTAL),
        bench.at_most(f"It is {_LATE:g} s or less in {_SHARE_LATE:g} %.", late, _LATE),
        _quick(f"With the whole roadmap, refined, it is {_WHOLE:g} s or less in the median.", whole, "total_s", _WHOLE),
        bench.at_most(f"Motions take {_DURATION:g} s or less in the mean.", _mean(timed), _DURATION),
        bench.at_most("They are no longer than roboplan's on the same problems, in the mean.", *durations),
    )


def _quick(sentence: str, rows: Sequence[bench.Row], name: str, most: float) -> bench.Verdict:
    return bench.at_most(sentence, median(row.get(name) for row in rows), most)


def _within(row: bench.Row) -> bool:
    return row.largest_share is not None and row.largest_share <= 1.0


def _of(rows: Sequence[bench.Row], method: str) -> list[bench.Row]:
    return [row for row in rows if row.method == method]


def _mean(rows: Sequence[bench.Row]) -> float | None:
    there = [row.duration_s for row in rows if row.duration_s is not None]
    return fmean(there) if there else None


def _both(rows: Sequence[bench.Row], method: str, name: str) -> list[tuple[float, float]]:
    """A field of our rows and of another method's, by its ``name``: of each problem that both solved and have it."""
    solved = [row for row in rows if row.outcome == SOLVED]
    ours, other = (
        {row.problem: value for row in _of(solved, each) if (value := getattr(row, name))} for each in (OURS, method)
    )
    return [(ours[problem], other[problem]) for problem in sorted(ours.keys() & other.keys())]


def _mean_durations(rows: Sequence[bench.Row]) -> tuple[float | None, float | None]:
    """Mean durations of ours and roboplan's over what both have timed."""
    both = _both(rows, ROBOPLAN, "duration_s")
    return (fmean(own for own, _ in both), fmean(other for _, other in both)) if both else (None, None)


def _solved(pick: bench.Pick) -> bench.Pick:
    return lambda rows: pick([row for row in rows if row.outcome == SOLVED])


def _timed(pick: bench.Pick) -> bench.Pick:
    return lambda rows: pick([row for row in rows if row.duration_s is not None])


def _share(read: bench.Read) -> bench.Pick:
    return lambda rows: f"{bench.total(read)(rows)} of {len(rows)}" if rows else None


_TABLE: dict[str, bench.Pick] = {
    "version": _solved(lambda rows: next((row.version for row in rows if row.version), "")),
    "solved": _solved(len),
    "of": len,
    "ready (s)": _solved(bench.middle("ready_s")),
    "first path (s)": _solved(bench.middle("first_s")),
    "after shortcuts (s)": _solved(bench.middle("path_s")),
    "motion (s)": _solved(bench.middle("motion_s")),
    "total (s)": _solved(bench.middle("total_s")),
    "98 % (s)": _solved(bench.middle(lambda r: r.path_s if r.total_s is None else r.total_s, share=_SHARE_LATE)),
    "CPU (s)": _solved(bench.middle("cpu_s")),
    "motion takes (s)": _mean,
    "length (rad)": _solved(bench.middle("length_rad")),
    "corners": _solved(bench.middle("corners")),
    "proven": _solved(_share(lambda row: bool(row.proven))),
    "paths touching": _solved(_share(lambda row: bool(row.contacts))),
    "motions touching": _timed(_share(lambda row: bool(row.motion_contact))),
    "largest share": _timed(bench.most("largest_share")),
}


def fault(row: bench.Row) -> str:
    """A problem that is not solved, or a contact."""
    found = [] if row.outcome == SOLVED else [f"{row.outcome}. {row.message or ''}"]
    found += [f"touches: {row.message or ''}"] if row.contacts else []
    found += [f"the motion touches: {row.motion_contact}"] if row.motion_contact else []
    return f"{row.problem}, {row.method}: {'; '.join(found)}" if found else ""
