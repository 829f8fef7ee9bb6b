"""One problem of ``benchmarks replan``, in a process of its own: a session, and change after change.

python -m benchmarks.replan.case out.json '{"robot": "panda", "scene": "scene0001.yaml", ...}'
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.memory import held_memory
from benchmarks.plan.case import path_contacts
from benchmarks.replan.changes import KINDS, Changer, Step
from benchmarks.replan.lifelong import repair_field
from benchmarks.replan.report import SIMULATED
from benchmarks.replan.simulation import simulate
from planner import gabf
from planner.base.arrays import Floats
from planner.base.errors import PlannerError
from planner.base.files import write_whole
from planner.batch.options import plan_request
from planner.collision import BACKENDS, make_checker
from planner.collision.edge_prover import EdgeProver
from planner.planning.result import Plan
from planner.problem.options import SessionOptions
from planner.problem.request import RoadmapRequest
from planner.sampling.grow import grow
from planner.sampling.growth_settings import GrowthSettings
from planner.session.session import Session
from planner.setup.open import make_query
from planner.trajectory.timing import time_path

_ANEW_EVERY = 5  # changes, for each kind: planning anew takes many times as long
_COMPARED = 100  # changes; of further ones only the session's own times, error and memory are measured

Columns = dict[str, Any]


def measure(request: RoadmapRequest, changes: int, simulations: int) -> list[Columns]:
    """The columns of a row per change and of one for the simulated runs.

    One row with a message where the problem cannot be planned at all.
    """
    query = make_query(request)
    scene, collision = replace(query.scene, carried=()), request.collision  # the robot carries it already
    session = Session(query.robot, scene, **_options(request))
    ends = query.starts[0], query.goals[0]
    last = session.plan(*ends)
    if not last.solved:
        return [{"kind": "none", "outcome": last.outcome.key, "message": "no path before any change."}]
    changer, rows = Changer(session, last, request.seed), []
    for k in range(changes):
        step = changer.step(KINDS[k % len(KINDS)])
        if step is None:
            continue
        rows.append(_columns(step))
        if k < _COMPARED:
            rows[-1] |= _field(last, step.plan) | _contacts(session, step.plan, collision)
            if (k // len(KINDS)) % _ANEW_EVERY == 0:
                rows[-1] |= _anew(session, request, *ends)
        last = step.plan
    return [*rows, *_simulated(session, last, simulations, request.seed)]


def _simulated(session: Session, answer: Plan, simulations: int, seed: int) -> list[Columns]:
    """The row of the runs among boxes that move, along the last path."""
    if not (answer.solved and simulations):
        return []
    found = simulate(session.checker, time_path(answer.path, session.checker, law="shortcuts"), simulations, seed)
    counts = {"runs": found.runs, "touched_before": found.before, "touched_after": found.after}
    return [{"kind": SIMULATED, "outcome": "solved", **counts, "horizon": found.horizon}]


def _columns(step: Step) -> Columns:
    answer, done = step.plan, step.plan.replanned
    return {
        "kind": step.kind,
        "outcome": answer.outcome.key,
        "seconds": step.change.seconds + answer.seconds,
        **asdict(answer.edges),
        "opened": step.change.edges.opened,
        "edges": answer.cost_to_go.network.n_arcs // 2 if answer.cost_to_go else None,
        "nodes_grown": done.nodes_grown,
        "rounds": done.rounds,
        "error": answer.max_error_vs_oracle or 0.0,
        "memory_mib": held_memory(),
    }


def _field(before: Plan, after: Plan) -> Columns:
    """The field of before healed in one go, and repaired by D* Lite; nothing where the nodes are others."""
    if before.cost_to_go is None or after.cost_to_go is None or before.cost_to_go.x.shape != after.cost_to_go.x.shape:
        return {}
    network, x = after.cost_to_go.network, before.cost_to_go.x
    start = int(after.path_nodes[0]) if len(after.path_nodes) else int(np.argmax(np.isfinite(x)))
    healing, healing_s = _timed(lambda: gabf.heal(network, x))
    repaired, repair_s = _timed(lambda: repair_field(network, x, start))
    _, dijkstra_s = _timed(lambda: gabf.oracle(network))
    return {
        "moved": len(healing.moved),
        "healing_updates": healing.updates,
        "healing_ms": 1e3 * healing_s,
        "lifelong_updates": repaired.updates,
        "lifelong_to_start": repaired.updates_to_start,
        "lifelong_ms": 1e3 * repair_s,
        "dijkstra_ms": 1e3 * dijkstra_s,
        "lifelong_error": gabf.max_error(repaired.x, gabf.oracle(network)),
    }


def _contacts(session: Session, answer: Plan, collision: str) -> Columns:
    """Segments of the path that touch something, by the library that did not prove it."""
    if not answer.solved:
        return {}
    other = next(name for name in BACKENDS if name != collision)
    return {"contacts": len(path_contacts(make_checker(session.robot, session.scene, other), answer.path))}


def _anew(session: Session, request: RoadmapRequest, start: Floats, goal: Floats) -> Columns:
    """Seconds for a first proven path by RRTConnect and for a whole plan, both from nothing in the scene as it is."""
    checker = make_checker(session.robot, session.scene, request.collision)
    joined, first_s = _timed(
        lambda: grow(EdgeProver(checker), start[None], goal[None], 0, request.seed, GrowthSettings()).joined
    )
    answer, plan_s = _timed(lambda: Session(session.robot, session.scene, **_options(request)).plan(start, goal))
    return {"first_path_s": first_s if joined else None, "anew_s": plan_s, "anew_solved": answer.solved}


def _options(request: RoadmapRequest) -> SessionOptions:
    """Those that are not the robot's, which stands as the request has it."""
    return {
        "collision": request.collision,
        "margin": request.margin,
        "nodes": request.nodes,
        "seed": request.seed,
        "min_manipulability": request.min_manipulability,
    }


def _timed(run: Any) -> tuple[Any, float]:
    begin = time.perf_counter()
    found = run()
    return found, time.perf_counter() - begin


def main(out: str, options: str) -> None:
    """What the process does: change, replan, measure, write."""
    values = json.loads(options)
    changes, simulations = values.pop("changes"), values.pop("simulations")
    try:
        rows = measure(plan_request(values), changes, simulations)
    except PlannerError as error:
        rows = [{"kind": "none", "outcome": "refused", "message": str(error)}]
    write_whole(Path(out), json.dumps(rows, allow_nan=False).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
