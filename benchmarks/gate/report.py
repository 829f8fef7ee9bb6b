"""The rows of ``benchmarks gate``, and the tables of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.bench import closing_lines
from planner.base.tables import markdown_table


@dataclass(frozen=True)
class Row:
    """Chunks of one kind for one robot: times of a check, what is refused without need, and an attack.

    ``p50_ms``, ``p99_ms``: of ``chunks`` checks on one thread after other work, ``_cpu`` by the thread's own clock,
    which other work on the machine does not count in; by that clock ``_again``: the same once more, ``_alone``: without
    stops. ``free_5``, ``free_20``: chunks that keep, stops included, 5 and 20 mm from everything as coal sees it every
    millimetre, and how many of these are called safe. ``change_ms``: the median of moving one obstacle after other
    work, ``change_again_ms``: of moving it back, by that clock. ``tries``: of the attack, of which ``safe`` were called
    safe, ``false`` of these touch or have no stop, ``beyond`` a limit. ``touching``: refused for a contact on the
    motion, of which samples every 0.05 rad call ``sampled`` free. ``hpp_pieces``: of the chunks of lines that are
    proven without stops, of which HPP proves ``hpp_proven`` in ``hpp_ms`` a chunk; None where it was not asked.
    """

    robot: str
    kind: str
    steps: int
    chunks: int
    attack: int
    seed: int
    p50_ms: float
    p99_ms: float
    p50_cpu_ms: float
    p99_cpu_ms: float
    p50_again_ms: float
    p99_again_ms: float
    p50_alone_ms: float
    p99_alone_ms: float
    change_ms: float
    change_again_ms: float
    safe_chunks: int
    free_5: int
    accepted_5: int
    free_20: int
    accepted_20: int
    tries: int
    safe: int
    false: int
    beyond: int
    least_mm: float
    touching: int
    sampled: int
    hpp_pieces: int | None
    hpp_proven: int | None
    hpp_ms: float | None
    software: str

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.robot, self.kind, self.steps, self.chunks, self.attack, self.seed, self.software


_TIMES = ("p50_ms", "p99_ms", "p50_cpu_ms", "p99_cpu_ms", "p50_again_ms", "p99_again_ms")
_TIMES = (*_TIMES, "p50_alone_ms", "p99_alone_ms", "change_ms", "change_again_ms")
_ACCEPTED = ("chunks", "safe_chunks", "free_5", "accepted_5", "free_20", "accepted_20")
_HPP = ("p50_alone_ms", "hpp_ms", "hpp_pieces", "hpp_proven")
_ATTACK = ("tries", "safe", "false", "beyond", "least_mm", "touching", "sampled")


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The tables for people: times, what is accepted, and the attack."""
    lines = ["# python -m benchmarks gate", ""]
    for title, names in (("Times", _TIMES), ("Accepted", _ACCEPTED), ("Attacked", _ATTACK), ("Beside HPP", _HPP)):
        header = ["robot", "kind", *(name.replace("_", " ") for name in names)]
        cells = [[row.robot, row.kind, *(_text(getattr(row, name)) for name in names)] for row in rows]
        lines += [f"## {title}", "", *markdown_table(header, cells), ""]
    return "\n".join([*lines, *closing_lines(rows, complete, "rows", _METHOD)]) + "\n"


def _text(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)


_METHOD = """How. A chunk is a smooth random motion of a robot among ten boxes of 4 to 20 cm; every check goes from the
present state on and proves a stop from every point, on one thread, after work that leaves nothing of it in the caches;
"again" is the same check once more, "alone" without stops, so the difference is their price. A chunk counts as free by
5 or 20 mm where the motion and all stops that the limits allow are so far from everything at every millimetre, by coal.
In the attack hill climbing moves targets and a thin obstacle towards a chunk that is called safe and touches; the judge
builds the controller's splines by itself, looks at them every 0.05 mm where anything may touch, by coal and by FCL
(what coal's own distances clear is passed over), and finds the extrema of their derivatives by roots. HPP proves
straight motions one by one, asked from Python, by Dichotomy without a tolerance; without limits and stops. Limitations.
Times are those of the machine as it was; states every 0.05 mm are no proof."""
