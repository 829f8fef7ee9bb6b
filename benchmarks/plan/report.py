"""The rows of ``benchmarks plan``, and their report: paths, motions, and settings side by side.

Columns. One problem planned once with one seed by one ``method``; results are None where there are none.

``options``: further options that are not at their defaults; ``limits`` of motions, in words; ``content``: a hash of the
problem's files. ``total_s`` of the wall clock and ``cpu_s`` of the processor: of the planning itself. ``timed_s``,
``blended_s``, ``stopping_s``: durations with shortcuts in time, with rounded corners only, and with a stop at each;
``timed_corners``, those ``blended``, and ``shortcuts`` of the first; ``proven``: as a whole; ``largest_share`` of any
limit, 1 is all of it; ``timing_cpu_s``: of the first.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from benchmarks import bench
from benchmarks.plan.case import OURS
from benchmarks.text import markdown_table, median
from planner.batch.run import CRASHED, NO_PATH, REFUSED, SOLVED, TIMED_OUT

GOAL_SECONDS = 10.0
BASE = "RRTConnect"


def settings(row: bench.Row) -> tuple[Any, ...]:
    """Return how a row was planned, without its problem and seed."""
    names = ("robot", "collision", "widen_limits", "method", "nodes_asked", "beta", "options")
    return tuple(row[name] for name in names)


def label(row: bench.Row) -> str:
    """Return the settings as text."""
    ours = f", {row.nodes_asked} nodes, beta {row.beta:g}" if row.method == OURS else f" by {row.method}"
    text = f"{row.robot}, {row.collision}{ours}" + (", limits widened" if row.widen_limits else "")
    return text + (f", {row.options}" if row.options else "")


def group(row: bench.Row) -> tuple[Any, ...]:
    """Return the settings, the problem and the seed of a row."""
    return settings(row), row.problem, row.seed


def by_settings(rows: Sequence[bench.Row]) -> dict[str, list[bench.Row]]:
    """The rows of each settings, under their label, sorted by problem and seed."""
    groups: dict[str, list[bench.Row]] = {}
    for row in sorted(rows, key=group):
        groups.setdefault(label(row), []).append(row)
    return groups


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """For each settings its paths and motions by scene type, and settings compared."""
    lines = []
    for label, of in by_settings(rows).items():
        lines += ["", f"## {label}", "", *bench.table(of, ["kind"], _PATHS, whole=True)]
        lines += bench.table([row for row in of if row.timed_s is not None], ["kind"], _MOTIONS, whole=True)
        lines += bench.aim_lines(aims(of, rows))
    limits = "; ".join(dict.fromkeys(row.limits for row in rows))
    return [*lines, "", *_comparison(rows), f"Limits of motions: {limits}."]


def _solved(pick: bench.Pick) -> bench.Pick:
    return lambda rows: pick([row for row in rows if row.outcome == SOLVED])


def _of_outcome(outcome: str) -> bench.Pick:
    return lambda rows: sum(row.outcome == outcome for row in rows)


def _in_time(row: bench.Row) -> bool:
    return row.outcome == SOLVED and row.total_s is not None and row.total_s <= GOAL_SECONDS


def _share_of_tried(rows: Sequence[bench.Row]) -> str:
    tried = [row for row in rows if row.outcome != REFUSED]
    return f"{100.0 * sum(row.outcome == SOLVED for row in tried) / len(tried):.0f} %" if tried else "-"


_PATHS: dict[str, bench.Pick] = {
    "runs": len,
    "refused": _of_outcome(REFUSED),
    "solved": _of_outcome(SOLVED),
    "of those tried": _share_of_tried,
    "in 10 s": bench.total(_in_time),
    "timed out": _of_outcome(TIMED_OUT),
    "no path": _of_outcome(NO_PATH),
    "crashed": _of_outcome(CRASHED),
    "time (s)": _solved(bench.middle("total_s")),
    "95 %": _solved(bench.middle("total_s", share=95.0)),
    "CPU (s)": _solved(bench.middle("cpu_s")),
    "first path (s)": _solved(bench.middle("first_path_s")),
    "length (rad)": _solved(bench.middle("length_rad")),
    "over straight": _solved(bench.middle(lambda row: bench.ratio(row.length_rad, row.straight_rad))),
    "tool (m)": _solved(bench.middle("length_m")),
    "corners": _solved(bench.middle("corners")),
    "min w": _solved(bench.middle("w_min")),
    "mean w": _solved(bench.middle("w_mean")),
    "dip": _solved(bench.total("dips")),
    "gap (%)": _solved(
        bench.middle(lambda row: bench.ratio(row.cost and row.cost - row.lower_bound, row.lower_bound), 100.0)
    ),
    "clearance (mm)": _solved(bench.middle("clearance_m", 1e3)),
    "least (mm)": _solved(bench.middle("clearance_m", 1e3, share=0.0)),
    "nodes": _solved(bench.middle("nodes")),
    "edges": _solved(bench.middle("edges")),
    "certified": _solved(bench.middle("certified")),
    "contacts": _solved(bench.total("contacts")),
}
_MOTIONS: dict[str, bench.Pick] = {
    "timed": len,
    "proven": bench.total("proven"),
    "contacts": bench.total(lambda row: bool(row.motion_contact)),
    "largest share": bench.most("largest_share"),
    "corners": bench.total("timed_corners"),
    "rounded": bench.total("blended"),
    "shortcuts": bench.total("shortcuts"),
    "ours (s)": bench.middle("timed_s"),
    "stopping (s)": bench.middle("stopping_s"),
    "share": bench.middle(lambda row: bench.ratio(row.timed_s, row.stopping_s)),
    "share, only rounded": bench.middle(lambda row: bench.ratio(row.blended_s, row.stopping_s)),
    "over toppra": bench.middle(lambda row: bench.ratio(row.timed_s, row.toppra_s)),
    "knots": bench.middle("knots"),
    "CPU (s)": bench.middle("timing_cpu_s"),
    "over roboplan": bench.middle(lambda row: bench.ratio(row.timed_s, row.roboplan_s)),
    "its largest share": bench.most("roboplan_share"),
    "its contacts": bench.total(lambda row: bool(row.roboplan_contact)),
}


def aims(rows: Sequence[bench.Row], everything: Sequence[bench.Row] = ()) -> tuple[bench.Verdict, ...]:
    """What plans of one settings are meant to show; of 0 where there is nothing to judge by."""
    if rows[0].method != OURS:
        return ()
    tried, solved = [row for row in rows if row.outcome != REFUSED], [row for row in rows if row.outcome == SOLVED]
    refused = f"Refused: {len(rows) - len(tried)}."
    return (
        bench.tally(
            f"Every problem whose states are within limits and free is solved within {GOAL_SECONDS:g} s.",
            map(_in_time, tried),
            refused,
        ),
        bench.tally("No contact is found on a returned path.", (row.contacts == 0 for row in solved), ""),
        bench.tally("Every edge of the roadmap is certified.", (row.certified == row.edges for row in solved), ""),
        *_aims_of_speed([row for row in solved if row.collision == "coal" and row.nodes_asked >= 1000]),
        *_aims_of_quality(solved, [row for row in everything if row.method == BASE and row.outcome == SOLVED]),
        *_aims_of_motions(solved),
    )


def _aims_of_speed(rows: Sequence[bench.Row]) -> list[bench.Verdict]:
    first, whole = (median(getattr(row, name) for row in rows) for name in ("first_path_s", "total_s"))
    return [
        bench.at_most("With coal a first proven path is there in 0.5 s in the median.", first, 0.5),
        bench.at_most("With coal the path from 1000 proven nodes is there in 5 s in the median.", whole, 5.0),
    ]


def _aims_of_quality(solved: Sequence[bench.Row], base: Sequence[bench.Row]) -> list[bench.Verdict]:
    beta = solved[0].beta if solved else None
    if beta not in (0.0, 1.0):
        return []
    ratios = {name: _ratios(base, solved, name) for name in ("length_rad", "w_mean")}
    if beta == 1.0:
        length, turns = median(ratios["length_rad"]), median(row.corners for row in solved)
        return [
            bench.at_most("At beta 1 length is at most 0.97 of RRTConnect's, simplified.", length, 0.97),
            bench.at_most("At beta 1 a path has at most 3 corners.", turns, 3.0),
        ]
    gain, share = median(ratios["w_mean"]), sum(bool(row.dips) for row in solved) / len(solved)
    sentence = "At beta 0 mean w is at least 1.2 times as large as RRTConnect's."
    return [
        bench.tally(sentence, [] if gain is None else [gain >= 1.2], "" if gain is None else f"It is {gain:.3g}."),
        bench.at_most("At beta 0 w dips below both ends in at most 10 % of paths.", share, 0.1),
    ]


def _aims_of_motions(solved: Sequence[bench.Row]) -> list[bench.Verdict]:
    share = median(bench.ratio(row.timed_s, row.stopping_s) for row in solved)
    over = median(bench.ratio(row.timed_s, row.toppra_s) for row in solved)
    within = (row.largest_share is not None and row.largest_share <= 1.0 for row in solved)
    return [
        bench.tally("Every path that is found is timed.", (row.timed_s is not None for row in solved), ""),
        bench.tally("Every motion is proven as a whole.", (bool(row.proven) for row in solved), ""),
        bench.tally("No contact is found at 0.1 mm of motion.", (not row.motion_contact for row in solved), ""),
        bench.tally("No limit is exceeded.", within, ""),
        bench.at_most("A motion takes 0.6 of stopping or less, in the median.", share, 0.6),
        bench.at_most("A motion takes 1.05 of toppra's time or less, in the median.", over, 1.05),
        bench.at_most("Timing takes 0.15 s or less, in the median.", median(row.timing_cpu_s for row in solved), 0.15),
    ]


def fault(row: bench.Row) -> str:
    """Return the reason why a run failed, or its contacts."""
    found = [] if row.outcome == SOLVED else [f"{row.outcome}: {row.message or ''}"]
    found += [f"{row.contacts} segments touch; {row.contact}"] if row.contacts else []
    found += [f"the motion touches: {row.motion_contact}"] if row.motion_contact else []
    found += ["not timed"] if row.method == OURS and row.outcome == SOLVED and row.timed_s is None else []
    return f"{row.problem}, seed {row.seed}, {label(row)}: {'; '.join(found)}" if found else ""


def _comparison(rows: Sequence[bench.Row]) -> list[str]:
    """Settings set side by side on the runs that both solved."""
    groups = sorted(by_settings(rows).items(), key=lambda group: _rank(group[1][0]))
    lines = [
        compare(one, first, two, second)
        for (one, first), (two, second) in itertools.combinations(groups, 2)
        if _comparable(first[0], second[0])
    ]
    header = ["settings", "against", "both solved", *(name for name, _ in _COMPARED), "only against", "only settings"]
    return ["## Compared", "", *markdown_table(header, lines, texts=2), ""] if lines else []


def _rank(row: bench.Row) -> tuple[Any, ...]:
    """The base of a comparison comes first: RRTConnect, length only, plain options, fewer nodes."""
    methods = [BASE, OURS, row.method]
    place = row.robot, row.collision, row.widen_limits, methods.index(row.method)
    return (*place, row.nodes_asked, -row.beta, row.options)


def _comparable(first: bench.Row, second: bench.Row) -> bool:
    """Every settings with RRTConnect; ours that differ in one point, or at one size from length only, beta = 1."""
    if settings(first)[:3] != settings(second)[:3] and BASE in (first.method, second.method):
        return False
    if first.method == BASE or second.method != OURS or first.method != OURS:
        return first.method == BASE
    differ = sum(a != b for a, b in zip(settings(first), settings(second), strict=True))
    same_size = (*settings(first)[:3], first.nodes_asked) == (*settings(second)[:3], second.nodes_asked)
    return differ == 1 or (same_size and first.beta == 1.0 and not first.options)


_COMPARED = (
    ("length", "length_rad"),
    ("tool", "length_m"),
    ("min w", "w_min"),
    ("mean w", "w_mean"),
    ("time", "total_s"),
    ("CPU", "cpu_s"),
)


def compare(one: str, first: Sequence[bench.Row], two: str, second: Sequence[bench.Row]) -> list[Any]:
    """Medians, over the runs of the same problem and seed that both solved, of the second's value over the first's."""
    mine, other = ({(r.problem, r.seed) for r in rows if r.outcome == SOLVED} for rows in (first, second))
    ratios = [median(_ratios(first, second, column)) for _, column in _COMPARED]
    return [two, one, len(mine & other), *ratios, len(mine - other), len(other - mine)]


def _ratios(base: Sequence[bench.Row], rows: Sequence[bench.Row], column: str) -> list[float]:
    """A column's value over that of ``base`` on the same problem and seed, where both are solved."""
    below = {(row.problem, row.seed): getattr(row, column) for row in base if row.outcome == SOLVED}
    found = (bench.ratio(getattr(r, column), below.get((r.problem, r.seed))) for r in rows if r.outcome == SOLVED)
    return [value for value in found if value is not None]
