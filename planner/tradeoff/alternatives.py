"""The paths that other betas would choose on a plan's network: what its page shows beside the plan's own path."""

from __future__ import annotations

from dataclasses import replace

from planner.base.progress import QUIET, Progress, Stopwatch
from planner.planning.result import Plan
from planner.roadmap.roadmap import path_waypoints
from planner.search.manipulability_floor import LayeredNetwork
from planner.search.search import ProvenNetwork
from planner.tradeoff.envelope import EnvelopeSearch, pieces
from planner.view.motion import ShownPath, path_rows


def with_alternatives(plan: Plan, progress: Progress = QUIET) -> Plan:
    """The plan with the paths that every other beta would choose on its network, for its page; a search of its own.

    One path for every interval of beta, sorted; none where the search was stopped. They consist of proven edges, and
    are not checked a second time. Their fields are the oracle's, which the dynamics would settle at. Where obstacles
    move there are none: no beta chooses among motions in time.
    """
    if plan.layered is None or plan.cost is None or plan.scene.moving:
        return plan
    clock = Stopwatch()
    with clock("alternatives"):
        found = _paths_for_every_beta(plan, plan.layered, progress)
    return replace(plan, alternatives=found, timings=plan.timings | clock.seconds)


def _paths_for_every_beta(plan: Plan, layered: LayeredNetwork, progress: Progress) -> tuple[ShownPath, ...]:
    search = EnvelopeSearch(ProvenNetwork(layered.network, layered.starts))
    while not search.done:
        if progress.stopped:
            return ()
        search.step()
        progress("other betas", int(100 * search.reach), 100)
    shown = []
    for piece in pieces(search.supports):
        support = piece.support
        path = path_waypoints(plan.roadmap, plan.robot, layered.roadmap_node[support.nodes])
        costs = support.manipulability, support.distance
        rows, field = path_rows(plan.robot, path, *costs), layered.on_roadmap(support.x)
        shown.append(ShownPath(path, rows, (piece.beta_min, piece.beta_max), field, costs))
    return tuple(shown)
