"""The rows of ``benchmarks plan``: a problem planned once with one seed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One run. Up to ``software``: the settings; then the results, None where there are none.

    ``content``: a hash of the problem's files. ``options``: further options of the plan that are not at their
    defaults. ``outcome``: solved, no_path, refused (by the ``message``), timed out or crashed. ``total_s``: seconds of
    the planning itself, ``process_s`` with the start of Python and the measurements. ``length_rad``: Euclidean joint
    motion; ``length_m``: the tool's path; ``w_min``, ``w_mean``: Yoshikawa's w sampled along the path; ``clearance_m``:
    the smallest distance every centimetre along the path; ``contacts``: segments of the path on which the other
    collision library finds a contact at a millimetre of motion, ``contact`` the first of them.
    """

    problem: str
    kind: str
    seed: int
    robot: str
    collision: str
    nodes_asked: int
    beta: float
    widen_limits: bool
    options: str
    time_limit_s: float
    content: str
    software: str
    outcome: str
    message: str
    total_s: float | None = None
    process_s: float | None = None
    setup_s: float | None = None
    first_path_s: float | None = None
    roadmap_s: float | None = None
    costs_s: float | None = None
    gabf_s: float | None = None
    path_s: float | None = None
    nodes: int | None = None
    edges: int | None = None
    certified: int | None = None
    waypoints: int | None = None
    length_rad: float | None = None
    length_m: float | None = None
    w_min: float | None = None
    w_mean: float | None = None
    clearance_m: float | None = None
    contacts: int | None = None
    contact: str | None = None
    memory_mib: float | None = None

    @property
    def key(self) -> tuple:
        """What was asked, apart from the time limit."""
        return (self.problem, self.seed, *self.settings, self.content, self.software)

    @property
    def place(self) -> tuple:
        """Where it stands in the file and in the report."""
        return self.settings, self.problem, self.seed

    @property
    def settings(self) -> tuple:
        """How it was planned, whatever the problem and the seed."""
        return self.robot, self.collision, self.nodes_asked, self.beta, self.widen_limits, self.options

    @property
    def label(self) -> str:
        """The settings as people read them."""
        robot, collision, nodes, beta, widened, options = self.settings
        text = f"{robot}, {collision}, {nodes} nodes, beta {beta:g}"
        return text + (", limits widened" if widened else "") + (f", {options}" if options else "")


def by_settings(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """The rows of each settings, under their label, sorted by problem and seed."""
    groups: dict[str, list[Row]] = {}
    for row in sorted(rows, key=lambda row: row.place):
        groups.setdefault(row.label, []).append(row)
    return groups


def of_outcome(rows: Sequence[Row], *outcomes: str) -> list[Row]:
    """Those of the rows that ended so."""
    return [row for row in rows if row.outcome in outcomes]
