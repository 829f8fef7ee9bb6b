"""The page of a trade-off: every path that some beta makes optimal, and those that none does."""

from __future__ import annotations

from planner.problem.outcome import Outcome
from planner.roadmap.record_text import roadmap_text
from planner.tradeoff.sweep import Tradeoff
from planner.view.page import Content, page
from planner.view.shown_path import Rows, ShownPath, path_rows


def sweep_page(tradeoff: Tradeoff) -> str:
    """A trade-off's page as HTML text, whatever part of it is there."""
    paths = of_tradeoff(tradeoff)
    beta = 0.5 if tradeoff.complete else 0.0
    content = Content(
        tradeoff.robot,
        tradeoff.scene,
        _message(tradeoff),
        tradeoff.roadmap.nodes[tradeoff.roadmap.starts[0]],
        details=_about_sweep(tradeoff),
        roadmap=tradeoff.roadmap,
        paths=paths,
        current=next((k for k, shown in enumerate(paths) if shown.interval and beta <= shown.interval[1]), 0),
        beta=beta,
        floor=tradeoff.request.quality.min_manipulability,
    )
    return page(content)


def of_tradeoff(tradeoff: Tradeoff) -> list[ShownPath]:
    """The trade-off's paths; those that are proven so far where it was interrupted."""
    return [
        ShownPath(
            item.path,
            path_rows(tradeoff.robot, item.path, item.manipulability_cost, item.distance_cost),
            (item.beta_min, item.beta_max),
            None if tradeoff.layered is None else tradeoff.layered.on_roadmap(item.cost_to_go.x),
            (item.manipulability_cost, item.distance_cost),
        )
        for item in tradeoff.intervals
    ]


def _message(tradeoff: Tradeoff) -> str:
    if tradeoff.outcome is not Outcome.SOLVED:
        return tradeoff.outcome.value
    count = len(tradeoff.intervals)
    return "One path is optimal for every β." if count == 1 else f"{count} paths, each optimal in its interval of β."


def _about_sweep(tradeoff: Tradeoff) -> Rows:
    rows = [("roadmap", roadmap_text(tradeoff.roadmap.record(tradeoff.edges_removed).to_dict()))]
    if tradeoff.solves:
        rows.append(("fields solved", str(tradeoff.solves)))
        rows.append(("error against oracle", f"{tradeoff.max_error_vs_oracle:.1e} relative"))
    return rows
