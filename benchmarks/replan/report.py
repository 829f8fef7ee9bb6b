"""A row per change of ``benchmarks replan``, and what the rows add up to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.bench import aim_lines, closing_lines
from benchmarks.replan.changes import KINDS
from planner.base.tables import markdown_table, median, percentile
from reproduce.verdict import Verdict, tally

_MANY = 1000  # changes from which on the memory of a session is told
SIMULATED = "simulated"  # the kind of a row that is no change


@dataclass(frozen=True)
class Row:
    """One change, or the runs among moving boxes along the last path of a problem.

    The first fields, ``widen_limits`` and ``software`` say what was asked, the others what came out. ``seconds``:
    the change and the answer after it; ``first_path_s`` and ``anew_s``: planning from nothing, for some of the
    changes. ``healing_...``: the field healed from the one before in a single run; ``lifelong_...``: D* Lite and
    LPA* from the same field, until the start is settled and until every node is. ``touched_...``: runs with a
    contact before the certified ``horizon`` (s), and after it.
    """

    problem: str
    robot: str
    collision: str
    nodes: int
    seed: int
    changes: int
    simulations: int
    content: str
    software: str
    number: int
    kind: str
    outcome: str
    message: str = ""
    widen_limits: bool = False
    seconds: float | None = None
    first_path_s: float | None = None
    anew_s: float | None = None
    anew_solved: bool | None = None
    edges: int | None = None
    opened: int | None = None
    proven: int | None = None
    removed: int | None = None
    regained: int | None = None
    nodes_grown: int | None = None
    rounds: int | None = None
    error: float | None = None
    moved: int | None = None
    healing_updates: int | None = None
    healing_ms: float | None = None
    lifelong_updates: int | None = None
    lifelong_to_start: int | None = None
    lifelong_ms: float | None = None
    lifelong_error: float | None = None
    dijkstra_ms: float | None = None
    runs: int | None = None
    touched_before: int | None = None
    touched_after: int | None = None
    horizon: float | None = None
    contacts: int | None = None
    memory_mib: float | None = None

    @property
    def asked(self) -> tuple:
        """What a process measures in one go."""
        asked = self.problem, self.robot, self.collision, self.nodes, self.seed, self.changes, self.simulations
        return (*asked, self.widen_limits, self.content, self.software)

    @property
    def key(self) -> tuple:
        """What was asked, and which change it is."""
        return (*self.asked, self.number)


def aims(rows: Sequence[Row]) -> tuple[Verdict, ...]:
    """What replanning is meant to be, and whether these rows show it."""
    coal = median(row.seconds for row in rows if row.collision == "coal" and row.kind == KINDS[-1])
    faster = median(row.anew_s / row.seconds for row in rows if row.anew_s and row.seconds)
    errors = [max(row.error, row.lifelong_error or 0.0) for row in rows if row.error is not None]
    return (
        tally(
            "With coal a new proven path is there in 0.15 s in the median after the route was blocked.",
            [] if coal is None else [coal <= 0.15],
            "" if coal is None else f"{coal:.3f} s.",
        ),
        tally(
            "Replanning is 10 times faster than planning anew in the median.",
            [] if faster is None else [faster >= 10.0],
            "" if faster is None else f"{faster:.1f} times.",
        ),
        tally("The healed field is Dijkstra's to 1e-9, D* Lite's too.", (error <= 1e-9 for error in errors), ""),
        tally(
            "No returned path touches anything.", (row.contacts == 0 for row in rows if row.contacts is not None), ""
        ),
        tally(
            "Boxes that move within their speed limits touch nothing before the certified horizon.",
            (row.touched_before == 0 for row in rows if row.runs),
            _simulated(rows),
        ),
    )


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The tables for people: replanning by kind of change, the field by how much of it moved, aims."""
    changed = [row for row in rows if row.seconds is not None]
    header = ["change", "changes", "solved", "time (s)", "95 %", "anew (s)", "solved anew", "first path anew (s)"]
    header += ["edges opened", "proven", "removed", "regained", "nodes grown", "rounds"]
    kinds = [_by_kind(kind, [row for row in changed if row.kind == kind]) for kind in KINDS]
    lines = ["# python -m benchmarks replan", "", *markdown_table(header, [*kinds, _by_kind("all", changed)]), ""]
    header = [
        "nodes whose x changed",
        "changes",
        "GABF: node updates",
        "ms",
        "D* Lite: to the start",
        "LPA*: all",
        "ms",
    ]
    lines += [*markdown_table([*header, "Dijkstra (ms)"], _by_size(changed)), "", *aim_lines(aims(rows))]
    lines += _lasting(changed)
    failed = [row for row in rows if row.seconds is None and row.kind != SIMULATED]
    lines += [f"- {row.problem}: {row.outcome}. {row.message}" for row in failed]
    return "\n".join([*lines, *closing_lines(rows, complete, "problems", _METHOD)]) + "\n"


def _lasting(rows: Sequence[Row]) -> list[str]:
    """What sessions of many changes held in memory: after a tenth of them, and at the end."""
    held: dict[str, list[float]] = {}
    for row in rows:
        if row.memory_mib is not None and row.changes >= _MANY:
            held.setdefault(row.problem, []).append(row.memory_mib)
    return [
        f"- {problem}: {len(found)} changes; its process held {found[len(found) // 10]:.0f} MiB after a tenth of them, "
        f"{found[-1]:.0f} MiB after the last, {max(found):.0f} MiB at most."
        for problem, found in held.items()
    ]


def _simulated(rows: Sequence[Row]) -> str:
    runs = [row for row in rows if row.runs]
    if not runs:
        return ""
    counts = [sum(getattr(row, name) or 0 for row in runs) for name in ("runs", "touched_before", "touched_after")]
    text = f"{counts[0]} runs, {counts[1]} contacts before it and {counts[2]} after it"
    return f"{text}; the horizon is {median(row.horizon for row in runs):.2f} s in the median."


def _by_kind(kind: str, rows: Sequence[Row]) -> list[Any]:
    anew = [row for row in rows if row.anew_s is not None]
    solved, again = sum(row.outcome == "solved" for row in rows), sum(bool(row.anew_solved) for row in anew)
    middle = [
        median(getattr(row, name) for row in rows)
        for name in ("opened", "proven", "removed", "regained", "nodes_grown", "rounds")
    ]
    times = median(row.seconds for row in rows), percentile((row.seconds for row in rows), 95.0)
    first = median(row.first_path_s for row in anew)
    return [kind, len(rows), solved, *times, median(r.anew_s for r in anew), f"{again} of {len(anew)}", first, *middle]


def _by_size(rows: Sequence[Row]) -> list[list[Any]]:
    lines = []
    for low, high in ((0, 1), (1, 10), (10, 100), (100, 1000), (1000, 10**9)):
        of = [row for row in rows if row.moved is not None and low <= row.moved < high]
        names = ("healing_updates", "healing_ms", "lifelong_to_start", "lifelong_updates", "lifelong_ms", "dijkstra_ms")
        size = "none" if high == 1 else f"{low} to {high - 1}" if high < 10**9 else f"{low} or more"
        if of:
            lines.append([size, len(of), *(median(getattr(row, name) for row in of) for name in names)])
    return lines


_METHOD = """How. Each problem has a session in a process of its own, with the roadmap of its first plan; the changes go
on from one another. A change that leaves the start or the goal in collision is undone and drawn again. Moved: an
obstacle, by up to 15 cm in each direction; added: a box of 4 to 12 cm near the route; removed: one of these; blocking:
one around the tool in the middle of the route. Time: the change and the answer, wall clock, with the second check of
what was proven anew, at every millimetre. Anew, after every fifth change of a kind: a whole plan in the scene as it is,
and OMPL's RRTConnect with its path proven but not checked a second time and without a field; libraries loaded, states
resolved. Contacts: by the library that did not prove, at every millimetre. Fields: from the one before the change to
the one after, where the nodes are the same. A node update is one minimum over a node's arcs; D* Lite ends once the
start is settled, LPA* settles every node, as GABF does; both without a heuristic. GABF's runs are vectorised, the
others are plain Python: compare updates rather than times. The dynamics computes every node in every step, wherever the
change was: it loses in updates to what touches only what changed. Simulated: three boxes of 5 to 20 cm with limits of
0.05 to 0.6 m/s move while the arm runs the last path in time, half of the runs for a joint, half at random and turning;
looked at by coal every 5 mm until 2 s after the certified horizon, beyond which nothing is claimed. Of more than 100
changes the later ones are neither compared nor looked at: there the error of the field and memory are measured."""
