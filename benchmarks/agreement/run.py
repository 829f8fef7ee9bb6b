"""``benchmarks agreement``: FCL and coal asked about the same configurations, of all robots in all scenes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.agreement.check_speed import Speed, measure_speed
from benchmarks.agreement.contact_band import Disagreement, crossing, disagreement
from benchmarks.agreement.report import Row, to_markdown
from benchmarks.bench import run_bench, software
from benchmarks.results import Results
from planner.base.arrays import Bools, Floats
from planner.base.errors import OptionError
from planner.base.progress import QUIET, Progress
from planner.base.resources import robot_names, scene_names
from planner.collision.checker import CollisionChecker, is_free
from planner.problem.request import SERIAL, WorkersRequest, WorldRequest, require_margin, require_seed
from planner.setup.open import open_world

CROSSINGS = 40  # contacts of each robot and scene whose surroundings are checked
_LISTED = 20  # disagreements of a row that are kept one by one


def bench_agreement(
    folder: Path,
    states: int = 100_000,
    robots: Sequence[str] = (),
    scenes: Sequence[str] = (),
    margin: float = 0.0,
    seed: int = 0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> Results[Row]:
    """Ask both libraries about ``states`` random configurations, shared out among all ``robots`` in all ``scenes``.

    All there are where none are named; a scene may be a file. Writes ``agreement.csv`` and ``agreement.md``; rows that
    are there already are kept. Once it is asked to stop the current robot and scene are abandoned. Raises OptionError
    for numbers out of range, RobotError and SceneError for unknown names, FileError where the folder cannot be used.
    """
    pairs = [(robot, scene) for robot in robots or robot_names() for scene in scenes or scene_names()]
    require_margin(margin)
    require_seed(seed)
    if states < 2 * len(pairs):
        raise OptionError(f"{states} states are too few for {len(pairs)} pairs of robot and scene: give more.")
    each = -(-states // len(pairs))
    here = software()
    return run_bench(
        folder,
        "agreement",
        Row,
        pairs,
        lambda table, pair: table.find((*pair, margin, seed, each, here)),
        partial(_measure, margin=margin, states=each, seed=seed),
        to_markdown,
        "worlds",
        progress,
        workers=workers,
    )


def _measure(pair: tuple[str, str], progress: Progress, margin: float, states: int, seed: int) -> list[Row]:
    """One robot in one scene; no row where stopped."""
    robot, scene = pair
    fcl = open_world(WorldRequest(robot, scene, collision="fcl", margin=margin))
    coal = open_world(WorldRequest(robot, scene, collision="coal", margin=margin))
    arm = fcl.robot
    rng = np.random.default_rng([seed, *robot.encode(), *Path(scene).name.encode()])
    q = rng.uniform(arm.lower, arm.upper, (states, arm.dof))
    free = verdicts(fcl, coal, q, progress)
    if free is None:
        return []
    by_fcl, by_coal = free
    differ = [one for k in np.nonzero(by_fcl != by_coal)[0] if (one := disagreement(fcl, coal, q[k])) is not None]
    both, neither = q[by_fcl & by_coal], q[~by_fcl & ~by_coal]
    count = min(CROSSINGS, len(both), len(neither))
    around = [one for a, b in zip(both[:count], neither[:count], strict=True) for one in crossing(fcl, coal, a, b)]
    row = Row(
        robot=robot,
        scene=scene,
        margin=margin,
        seed=seed,
        states=states,
        free=int(by_fcl.sum()),
        disagreed=int((by_fcl != by_coal).sum()),
        unexplained=sum(not one.explained for one in differ),
        batch_differs=sum(batch_differences(checker, both, neither) for checker in (fcl, coal)),
        crossings=count,
        band_m=max((one.band_m for one in around), default=0.0),
        **_speed_columns(measure_speed({"fcl": fcl, "coal": coal}, both)),
        listed=json.dumps([asdict(one) for one in [*differ, *_outside(around)][:_LISTED]]),
        software=software(),
    )
    return [row]


def verdicts(
    fcl: CollisionChecker, coal: CollisionChecker, q: Floats, progress: Progress = QUIET
) -> tuple[Bools, Bools] | None:
    """Which configurations (n, dof) each of the two calls free, asked one by one; None where stopped."""
    free = np.empty((2, len(q)), dtype=bool)
    for k, row in enumerate(q):
        if progress.stopped:
            return None
        free[:, k] = is_free(fcl, row), is_free(coal, row)
    return free[0], free[1]


def _outside(around: Sequence[Disagreement]) -> list[Disagreement]:
    """Those around a contact that lie outside the band, the worst first."""
    return sorted((one for one in around if not one.explained), key=lambda one: -one.band_m)


def batch_differences(checker: CollisionChecker, free: Floats, touching: Floats) -> int:
    """Configurations on which a checker changes its verdict when it is asked about them together with others."""
    wrong = 0 if not len(free) or checker.bound.looks_free(free) else 1
    beside = free[:1] if len(free) else touching[:0]
    for q in touching:
        batch = np.vstack([beside, q, beside])
        found = checker.first_contact(batch)
        wrong += found is None or found[0] != len(beside) or checker.bound.looks_free(batch)
    return wrong


def _speed_columns(speed: dict[str, Speed]) -> dict[str, float | None]:
    return {f"{name}_{look}": value for name, of in speed.items() for look, value in asdict(of).items()}
