"""The page of a trade-off: every path that some beta makes optimal, and those that none does."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Ints
from planner.problem.outcome import Outcome
from planner.roadmap.record_text import roadmap_text
from planner.roadmap.roadmap import path_waypoints
from planner.tradeoff.sweep import Tradeoff, reached_by_beta
from planner.view.page import Content, page
from planner.view.shown_path import Rows, ShownPath, path_rows

MOST_BEYOND = 30  # paths that no beta reaches, drawn at most: each is some ten kilobytes of a page


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
        floor=tradeoff.request.min_manipulability,
    )
    return page(content)


def of_tradeoff(tradeoff: Tradeoff) -> list[ShownPath]:
    """The trade-off's paths; those that are proven so far where it was interrupted. Those that no beta reaches last."""
    optimal = [
        ShownPath(
            item.path,
            path_rows(tradeoff.robot, item.path, item.manipulability_cost, item.distance_cost),
            (item.beta_min, item.beta_max),
            None if tradeoff.layered is None else tradeoff.layered.on_roadmap(item.cost_to_go.x),
            (item.manipulability_cost, item.distance_cost),
        )
        for item in tradeoff.intervals
    ]
    return [*optimal, *_beyond_beta(tradeoff)]


def _rows_beyond_beta(tradeoff: Tradeoff) -> Ints:
    if tradeoff.front is None:
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(~reached_by_beta(tradeoff.front.points, tradeoff.intervals))


def _beyond_beta(tradeoff: Tradeoff) -> list[ShownPath]:
    """Non-dominated paths that no beta reaches by Omega; of many, some evenly spread over all."""
    rows, front = _rows_beyond_beta(tradeoff), tradeoff.front
    if len(rows) > MOST_BEYOND:
        rows = rows[np.linspace(0, len(rows) - 1, MOST_BEYOND).round().astype(np.int64)]
    shown: list[ShownPath] = []
    if front is None:
        return shown
    for row in rows:
        path = path_waypoints(tradeoff.roadmap, tradeoff.robot, front.paths[row])
        omega, distance = front.points[row].tolist()
        shown.append(ShownPath(path, path_rows(tradeoff.robot, path, omega, distance), costs=(omega, distance)))
    return shown


def _message(tradeoff: Tradeoff) -> str:
    if tradeoff.outcome is not Outcome.SOLVED:
        return tradeoff.outcome.value
    count = len(tradeoff.intervals)
    return "One path is optimal for every β." if count == 1 else f"{count} paths, each optimal in its interval of β."


def _about_sweep(tradeoff: Tradeoff) -> Rows:
    rows = [("roadmap", roadmap_text(tradeoff.roadmap.record(tradeoff.edges_removed)))]
    if tradeoff.solves:
        rows.append(("fields solved", str(tradeoff.solves)))
        rows.append(("error against oracle", f"{tradeoff.max_error_vs_oracle:.1e} relative"))
    if tradeoff.front is not None:
        more = "" if tradeoff.front.complete else ", and perhaps more: the search was stopped"
        beyond = len(_rows_beyond_beta(tradeoff))
        some = f" ({MOST_BEYOND} of them are drawn)" if beyond > MOST_BEYOND else ""
        rows.append(("non-dominated paths", f"{len(tradeoff.front.points)}, {beyond} of no β{some}{more}"))
    return rows
