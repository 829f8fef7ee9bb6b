"""The rows of ``benchmarks attack``, and the tables of them.

Columns. One attack on one library: ``attack`` is the part of the benchmark, ``first`` and ``second`` its target.

Targets: two kinds of shapes; a robot and a kind of obstacle; a problem (``library``: HPP's method); a robot and a
scene; a chunk of changes. ``tried``, of which ``free`` are called free, proven or accepted, ``false_free`` wrongly.

Metres of claims: the largest claim minus truth of each call (``distances_m`` to ``verdict_m``; empty where the call
claimed nothing), of the clearance of a free segment; ``beyond_m``: the largest of them minus what the contract allows;
``short_m``: the largest truth minus what ``distances`` says; ``open_m``: the widest doubt about a truth. ``apart``:
cases that do not touch. Edges past thin obstacles: ``touching`` at 0.1 mm by coal, ``left_out``: free there and not
certified, ``looks``: configurations sampled. Motions compared with HPP: proven by ``both``, ``only_ours``,
``only_theirs``; of these two so many on which coal sees a contact at 0.1 mm; seconds of the wall clock for all.
Certificates: seconds of computing, bytes, ``verdict`` is "proven" or the reason why it is not; ``counts`` of changes by
kind, tried and accepted, as JSON. ``found``: the worst cases, as JSON.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence

from benchmarks import bench
from benchmarks.attack.claims import ROUNDING
from benchmarks.text import markdown_table
from planner.collision import BACKENDS


def aims(rows: Sequence[bench.Row]) -> tuple[bench.Verdict, ...]:
    """The claims that must hold; of 0 where one was not attacked."""
    return tuple(
        bench.tally(sentence, map(holds, some), f"{sum(row.tried or 0 for row in some)} tried.")
        for part, (sentence, holds) in _MUST.items()
        if (some := [row for row in rows if row.attack == part and row.library in (*BACKENDS, *_OTHERS)])
    )


_OTHERS = ("", "Dichotomy", "Progressive")  # OMPL's rule is the one that is expected to fail
_MUST: dict[str, tuple[str, Callable[[bench.Row], bool]]] = {
    "claims": ("No call claims more than the truth and its error.", lambda row: (row.beyond_m or 0.0) <= 0.0),
    "segments": (
        "No segment that is called free touches, and none is closer than its clearance.",
        lambda row: row.false_free == 0 and (row.clearance_m or 0.0) <= ROUNDING,
    ),
    "misses": ("No proven edge past a thin obstacle touches.", lambda row: row.false_free == 0),
    "proofs": ("No motion touches that we alone prove.", lambda row: not row.only_ours_touching),
    "certificates": ("Every certificate of a plan is accepted.", lambda row: row.verdict == "proven"),
    "changes": ("No changed certificate that is false is accepted.", lambda row: row.false_free == 0),
}


def fault(row: bench.Row) -> str:
    """A broken claim, or the reason why one was not attacked."""
    broken = any(aim.confirmed < aim.of for aim in aims([row]))
    found = [row.message] if row.message else []
    found += [row.found or row.verdict] if broken else []
    return f"{row.library} {row.attack}, {row.first} {row.second}: {'; '.join(found)}" if found else ""


def tables(rows: Sequence[bench.Row]) -> list[str]:
    """A table for each part, the libraries of a target one below the other."""
    lines = []
    for part, columns in _COLUMNS.items():
        chosen = [row for row in rows if row.attack == part]
        if not chosen:
            continue
        lines += [f"## {part}", ""]
        if part == "misses":
            lines += _sums(chosen, ["second", "thickness_mm", "library"], columns)
            lines += _sums(chosen, ["first", "library"], columns)
        elif part == "proofs":
            lines += _sums([row for row in chosen if not row.message], ["library"], columns)
        elif part == "changes":
            lines += _changes(chosen)
        else:
            targets = list(dict.fromkeys((row.first, row.second) for row in chosen))
            chosen.sort(key=lambda row: (targets.index((row.first, row.second)), row.library != BACKENDS[0]))
            lines += bench.row_table(chosen, ("first", "second", "library"), columns)
    return lines


_COLUMNS = {
    "claims": ("tried", "apart", "distances_m", "coarse_m", "close_m", "verdict_m", "beyond_m", "short_m"),
    "segments": ("tried", "free", "false_free", "clearance_m"),
    "misses": ("tried", "touching", "free", "false_free", "left_out", "looks"),
    "proofs": (
        "tried",
        "free",
        "both",
        "only_ours",
        "only_ours_touching",
        "only_theirs",
        "only_theirs_touching",
        "ours_s",
        "theirs_s",
    ),
    "certificates": ("plan_s", "certify_s", "check_s", "size", "witnesses", "verdict"),
    "changes": (),
}


def _sums(rows: Sequence[bench.Row], by: Sequence[str], names: Sequence[str]) -> list[str]:
    return bench.table(rows, by, {name.replace("_", " "): bench.total(name) for name in names})


def _changes(rows: Sequence[bench.Row]) -> list[str]:
    """How many certificates were changed and accepted, by kind of change."""
    counts: dict[str, list[int]] = {}
    for row in rows:
        for kind, (tried, accepted) in json.loads(row.counts).items():
            before = counts.setdefault(kind, [0, 0])
            counts[kind] = [before[0] + tried, before[1] + accepted]
    lines = [[kind, *numbers] for kind, numbers in sorted(counts.items())]
    return [*markdown_table(["changed", "certificates", "accepted"], lines), ""]
