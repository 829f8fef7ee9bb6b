"""The paths that other betas would choose on a plan's network: what its page shows beside the plan's own path."""

from __future__ import annotations

from planner.base.progress import QUIET, Progress
from planner.costs.manipulability_floor import LayeredNetwork
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.tradeoff.envelope import EnvelopeSearch, pieces
from planner.view.shown_path import ShownPath, on_roadmap, path_rows
from planner.world.robot import Robot


def paths_for_every_beta(
    roadmap: Roadmap, robot: Robot, layered: LayeredNetwork, progress: Progress = QUIET
) -> tuple[ShownPath, ...]:
    """One path for every interval of beta, sorted; none where the search was stopped.

    They consist of proven edges, and are not checked a second time. Their fields are the oracle's, which the dynamics
    would settle at.
    """
    search = EnvelopeSearch(layered.network, layered.starts)
    while not search.done:
        if progress.stopped:
            return ()
        search.step()
        progress("other betas", int(100 * search.reach), 100)
    shown = []
    for piece in pieces(search.supports):
        support = piece.support
        path = path_waypoints(roadmap, robot, layered.roadmap_node[support.nodes])
        costs = support.manipulability, support.distance
        field = on_roadmap(layered, support.x)
        shown.append(ShownPath(path, path_rows(robot, path, *costs), (piece.beta_min, piece.beta_max), field, costs))
    return tuple(shown)
