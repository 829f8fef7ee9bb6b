"""How plans, trade-offs and roadmaps show themselves in a notebook: a small table, and the page on request.

The table keeps a committed notebook small; :func:`show` puts the whole page into the cell, some megabytes. Importing
this module loads nothing heavy: ``import planner`` does so in every IPython session.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from planner.base.errors import OptionError

if TYPE_CHECKING:
    from planner.collision.checker import CollisionChecker
    from planner.planning import Plan
    from planner.roadmap.roadmap import Roadmap
    from planner.tradeoff.sweep import Tradeoff


@dataclass(frozen=True, repr=False)
class InlinePage:
    """A page as a notebook cell shows it, ``height`` pixels high."""

    html: str
    height: int

    def _repr_html_(self) -> str:
        # no allow-same-origin: what a scene file was named cannot reach the notebook
        style = f"width:100%;height:{self.height}px;border:0"
        return f'<iframe sandbox="allow-scripts" style="{style}" srcdoc="{escape(self.html)}"></iframe>'

    def __repr__(self) -> str:
        return f"<page of {len(self.html) / 1e6:.1f} MB>"


def show(thing: Plan | Tradeoff | Roadmap, checker: CollisionChecker | None = None, height: int = 640) -> InlinePage:
    """The interactive page of a plan or a trade-off in a notebook cell; of a roadmap, with the checker of its world.

        planner.show(plan)
        planner.show(roadmap, checker)

    Raises :class:`OptionError` for anything else.
    """
    from planner.planning import Plan
    from planner.roadmap.roadmap import Roadmap
    from planner.tradeoff.sweep import Tradeoff
    from planner.view.page import plan_page, roadmap_page, sweep_page

    match thing:
        case Plan():
            return InlinePage(plan_page(thing), height)
        case Tradeoff():
            return InlinePage(sweep_page(thing), height)
        case Roadmap() if checker is not None:
            return InlinePage(roadmap_page(thing, checker), height)
        case Roadmap():
            raise OptionError(
                "a roadmap holds no geometry: give the checker it was grown with, show(roadmap, checker)."
            )
    raise OptionError(f"a {type(thing).__name__} has no page: give a Plan, a Tradeoff, or a Roadmap and its checker.")


def register(shell: Any) -> None:
    """Make an IPython shell show our results as tables, and in text as one line."""
    formatters = shell.display_formatter.formatters
    for module, name, table in (
        ("planner.planning", "Plan", plan_table),
        ("planner.tradeoff.sweep", "Tradeoff", tradeoff_table),
        ("planner.roadmap.roadmap", "Roadmap", roadmap_table),
    ):
        formatters["text/html"].for_type_by_name(module, name, table)
        formatters["text/plain"].for_type_by_name(module, name, _one_line(name))


def plan_table(plan: Plan) -> str:
    """A plan as an HTML table."""
    from planner.plan_record import plan_record, summary_rows

    return _table(f"{plan.robot.name} in {plan.scene.name}. {plan.outcome.value}", summary_rows(plan_record(plan)))


def tradeoff_table(tradeoff: Tradeoff) -> str:
    """A trade-off as an HTML table, a row an interval of beta."""
    from planner.tradeoff.record import interval_rows, summary_lines, sweep_record

    record = sweep_record(tradeoff)
    rows = interval_rows(record)
    caption = (
        f"{tradeoff.robot.name} in {tradeoff.scene.name}. {tradeoff.outcome.value} {' '.join(summary_lines(record))}"
    )
    cells = [[_number(value) for value in row.values()] for row in rows]
    return _table(caption, cells, list(rows[0]) if rows else [])


def roadmap_table(roadmap: Roadmap) -> str:
    """A roadmap as an HTML table."""
    from planner.roadmap.summary import roadmap_record, roadmap_text

    w, length, origin = roadmap.manipulability, roadmap.joint_length, roadmap.origin
    rows = [
        ("size", roadmap_text(roadmap_record(roadmap, 0))),
        ("starts, goals", f"{len(roadmap.starts)}, {len(roadmap.goals)}"),
        ("manipulability w", f"{w.min():.3g} to {w.max():.3g} at its nodes"),
        ("seed", str(origin.seed)),
    ]
    if len(length):
        rows.insert(3, ("edges", f"mean {length.mean():.3f} rad, longest {length.max():.3f} rad"))
    return _table(f"Roadmap of {origin.robot} in {origin.scene}", rows)


def _one_line(name: str) -> Callable[[Any, Any, bool], None]:
    """A printer for IPython's text: a result's own repr holds every number in it."""
    return lambda thing, printer, cycle: printer.text(f"<planner.{name}>")


def _number(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _table(caption: str, rows: Sequence[Sequence[str]], head: Sequence[str] = ()) -> str:
    """Cells as text: names out of files cannot become markup."""
    top = f"<thead>{_row('th', head)}</thead>" if head else ""
    body = "".join(_row("td", row) for row in rows)
    return f"<p>{escape(caption)}</p><table>{top}<tbody>{body}</tbody></table>"


def _row(tag: str, cells: Sequence[str]) -> str:
    return "<tr>" + "".join(f'<{tag} style="text-align:left">{escape(cell)}</{tag}>' for cell in cells) + "</tr>"
