"""The rows of ``benchmarks misses``, and the tables of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from benchmarks.bench import closing_lines
from planner.base.tables import markdown_table


@dataclass(frozen=True)
class Row:
    """One kind of obstacle of one thickness before one robot; counts of edges.

    ``touching``: with a contact when sampled every 0.1 mm of motion by coal. ``ompl_free``: OMPL's default rule finds
    no contact, checked by coal; ``ompl_missed``: of these, touching. ``fcl_proven``, ``coal_proven``: certified by our
    prover with that backend; ``fcl_missed``: of these, with a contact that coal finds every 0.1 mm, ``coal_missed``:
    with a contact that FCL finds. ``fcl_left_out``, ``coal_left_out``: free at 0.1 mm and not certified. ``looks``:
    configurations sampled every 0.1 mm. ``found``: the first edges missed by the prover, as JSON.
    """

    robot: str
    obstacle: str
    thickness_mm: float
    edges: int
    seed: int
    touching: int
    ompl_free: int
    ompl_missed: int
    fcl_proven: int
    fcl_missed: int
    fcl_left_out: int
    coal_proven: int
    coal_missed: int
    coal_left_out: int
    looks: int
    found: str
    software: str

    @property
    def key(self) -> tuple:
        """What was asked."""
        return self.robot, self.obstacle, self.thickness_mm, self.edges, self.seed, self.software


_COUNTS = ("edges", "touching", "ompl_free", "ompl_missed", "fcl_proven", "fcl_missed", "fcl_left_out")
_COUNTS += ("coal_proven", "coal_missed", "coal_left_out", "looks")


def to_markdown(rows: Sequence[Row], complete: bool = True) -> str:
    """The tables for people: what it adds up to, by obstacle and thickness, by robot, and every miss of the proof."""
    lines = ["# python -m benchmarks misses", "", _total(rows), "", *_table(rows, "obstacle", "thickness_mm")]
    lines += ["", *_table(rows, "robot"), ""]
    lines += [f"- Missed before {row.robot}: {row.found}" for row in rows if row.fcl_missed or row.coal_missed]
    return "\n".join([*lines, *closing_lines(rows, complete, "rows", _METHOD)]) + "\n"


def _total(rows: Sequence[Row]) -> str:
    whole = _sums(rows)
    return (
        f"Of {whole['edges']} edges with free ends, {whole['touching']} touch a thin obstacle or the arm itself when "
        f"sampled every 0.1 mm. OMPL's default rule calls {whole['ompl_free']} free, of which "
        f"**{whole['ompl_missed']} touch**. The proof certifies {whole['fcl_proven']} with FCL, of which "
        f"**{whole['fcl_missed']} touch**, and {whole['coal_proven']} with coal, of which **{whole['coal_missed']} "
        f"touch**; {whole['fcl_left_out']} and {whole['coal_left_out']} edges without a contact were left out."
    )


def _sums(rows: Iterable[Row]) -> dict[str, int]:
    rows = list(rows)
    return {name: sum(getattr(row, name) for row in rows) for name in _COUNTS}


def _table(rows: Sequence[Row], *by: str) -> list[str]:
    groups = dict.fromkeys(tuple(getattr(row, name) for name in by) for row in rows)
    lines = [
        [*group, *_sums(row for row in rows if tuple(getattr(row, name) for name in by) == group).values()]
        for group in groups
    ]
    header = [name.replace("thickness_mm", "mm").replace("_", " ") for name in (*by, *_COUNTS)]
    return markdown_table(header, lines)


_METHOD = """How. Walls, poles (round or square) and windows (four boards) of the given thickness stand where a link of
a random edge passes, at a random pose, a little off; an edge counts when both its ends are free. Every edge is put to
the prover of `planner.collision.edge_prover` with FCL and with coal. Every edge is sampled at each 0.1 mm of motion of
any point of the arm by coal, and those that the prover certified with coal by FCL as well: an edge certified with one
library on which the other finds a contact is missed. OMPL's rule is that of its DiscreteMotionValidator with default
settings: equal parts no longer than 0.01 of the space's largest extent, those states checked by coal. "Left out" are
edges on which no contact was found and which were not certified: passing closer than the proof resolves, or than 0.1
mm shows. Limitations. The states every 0.1 mm are no proof: a contact shorter than that is not seen. The edges are
short (0.3 to 1.2 m of motion) and aimed at the obstacle, so the shares are not those of a usual scene."""
