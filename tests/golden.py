"""Answers that a change of the code must not change: roadmaps, paths, motions, verdicts and certificates.

Every case uses the library as a user does. ``python -m tests.golden [NAME ...]`` writes ``golden.json`` (or only the
named cases), for a change that means to alter them: its commit message says so.
"""

import hashlib
import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

import planner
from planner.base.resources import versions

FILE = Path(__file__).with_name("golden.json")
SCENES = Path(__file__).parent.parent / "scenes"
EXAMPLES = SCENES / "examples"
PLANS: dict[str, dict[str, Any]] = {
    "iiwa14 in paper, FCL": {"nodes": 60},
    "iiwa14 in paper, coal, charged edges, floor": {
        **{"nodes": 80, "collision": "coal", "cost_integration": "edges", "min_manipulability": 0.02}
    },
    "panda in shelf, FCL": {"robot": "panda", "scene": "shelf", "nodes": 60},
    "panda in shelf, coal": {
        **{"robot": "panda", "scene": "shelf", "nodes": 60, "collision": "coal", "beta": 0.2, "seed": 3}
    },
    "ur5 in table, coal": {"robot": "ur5", "scene": "table", "nodes": 40, "collision": "coal"},
    "kinova in window, coal": {"robot": "kinova", "scene": "window", "nodes": 40, "collision": "coal"},
    "planar_2r in cage, FCL": {"robot": "planar_2r", "scene": "cage", "nodes": 40},
    "panda in empty, tool axis and plane kept, coal": {
        **{"robot": "panda", "scene": "empty", "start": "home", "goal": "xyz:-0.4,-0.4,0.5", "collision": "coal"},
        **{"constraint": ("axis:z,0,0,-1,0.0873", "plane:0,0,1,0.3"), "nodes": 60},
    },
    "paper's scenario, all defaults": {},
}
TIMED: dict[str, dict[str, Any]] = {  # one for each scene
    "cage": {"robot": "planar_2r", "scene": "cage", "nodes": 60},
    "empty": {"robot": "ur10", "scene": "empty", "nodes": 60, "start": "home", "goal": "q:0.5,-1,1,-1.2,0.3,0.4"},
    "paper": {"nodes": 100, "collision": "coal", "beta": 0.2},
    "shelf": {"robot": "panda", "scene": "shelf", "path_only": True},
    "table": {"robot": "xarm7", "scene": "table", "nodes": 60},
    "window": {"robot": "kinova", "scene": "window", "nodes": 60},
    "gcs": {"scene": SCENES / "published" / "gcs.yaml", "start": "above-shelf", "goal": "top-shelf", "nodes": 60},
    "shelf of today": {"robot": "panda", "scene": EXAMPLES / "shelf-of-today.yaml", "nodes": 60, "seed": 3},
    "two boards": {
        **{"robot": "panda", "scene": EXAMPLES / "two-boards.yaml", "start": "home", "nodes": 60},
        "goal": "xyz:0.4,-0.3,0.3",
    },
    "cart": {"robot": "panda", "scene": EXAMPLES / "cart.yaml", "nodes": 60},
    "MoveIt request": {
        **{"motion_plan_request": EXAMPLES / "request0001.yaml", "scene": EXAMPLES / "scene0001.yaml"},
        **{"robot": "panda", "nodes": 60},
    },
}


def digest(*arrays: np.ndarray) -> str:
    """The hash of the bytes of arrays; zeros without their sign."""
    sha = hashlib.sha256()
    for array in arrays:
        sha.update((np.asarray(array, dtype=float) + 0.0).tobytes())
    return sha.hexdigest()


def plan(options: dict[str, Any]) -> dict[str, Any]:
    made = planner.plan(timing=None, **options)
    return {"outcome": made.outcome.key, "roadmap": made.roadmap.sha256, "path": digest(made.path)}


def timed(options: dict[str, Any]) -> dict[str, Any]:
    return motion_of(planner.plan(timing=planner.TimingRequest(), **options))


def motion_of(made: planner.Plan) -> dict[str, Any]:
    kept = {"outcome": made.outcome.key, "path": digest(made.path)}
    return kept if made.trajectory is None else kept | {"motion": knots(made.trajectory)}


def knots(motion: planner.Trajectory) -> str:
    return digest(motion.times, motion.coefficients)


def intervals() -> list[list[float]]:
    tradeoff = planner.sweep(request=planner.PlanRequest.from_options(nodes=80, collision="coal"))
    return [[round(value, 12) for value in (row.beta_min, row.beta_max, row.w_min)] for row in tradeoff.intervals]


def follow() -> dict[str, Any]:
    timing = planner.TimingRequest()
    return motion_of(planner.follow(EXAMPLES / "seam.yaml", robot="panda", scene="table", timing=timing))


def task() -> dict[str, Any]:
    made = planner.task(EXAMPLES / "tidy.yaml", nodes=60, timing=None)
    segments = [digest(segment.path) for segment in made.segments]
    return {"outcome": made.outcome.key, "segments": segments}


def session() -> list[dict[str, Any]]:
    """Answers of a session before and after each of three changes."""
    live = planner.Session("panda", "shelf", collision="coal", nodes=200)
    plans = [live.plan("start", "goal", timing=None)]
    live.move("divider", position=[0.1, 0.62, 0.8])
    plans.append(live.replan())
    pole = planner.Obstacle("pole", planner.Cylinder(0.03, 1.4), planner.pose([0.35, 0.25, 0.7]))
    live.add(pole)
    plans.append(live.replan())
    live.remove("low board")
    plans.append(live.replan())
    return [{"outcome": made.outcome.key, "path": digest(made.path)} for made in plans]


def verdicts() -> dict[str, Any]:
    """200 chunks of five points from states at rest, near and far from the shelf."""
    gate = planner.Gate("panda", "shelf", collision="coal")
    robot, rng = gate.robot, np.random.default_rng(0)
    low, high = (np.array(limit) for limit in (robot.lower, robot.upper))
    times, safe, until, stops = np.array([0.1, 0.2, 0.3, 0.4, 0.5]), [], [], []
    while len(safe) < 200:
        q = np.clip(np.array(robot.home) + rng.normal(scale=0.5, size=robot.dof), low + 0.1, high - 0.1)
        speed = rng.normal(scale=0.3, size=robot.dof)
        points = q + speed * (times**2 / times[-1])[:, None]
        verdict = gate.check(points, times=times, state=(q, np.zeros(robot.dof)))
        safe.append(float(verdict.safe))
        until.append(verdict.safe_until)
        stop = verdict.stop
        stops.append(digest() if stop is None else knots(stop))
    text = hashlib.sha256("".join(stops).encode()).hexdigest()
    return {"safe": int(sum(safe)), "until": digest(np.array(until)), "stops": text}


def certificate() -> str:
    made = planner.plan(robot="panda", scene="shelf", nodes=60, collision="coal", timing=planner.TimingRequest())
    proof = made.certify()
    return digest(*(proof.arrays[name] for name in sorted(proof.arrays) if proof.arrays[name].dtype.kind in "fiu"))


CASES: dict[str, Callable[[], Any]] = {
    **{f"plan: {name}": (lambda options=options: plan(options)) for name, options in PLANS.items()},
    **{f"motion: {name}": (lambda options=options: timed(options)) for name, options in TIMED.items()},
    **{"sweep": intervals, "follow": follow, "task": task, "session": session},
    **{"gate": verdicts, "certificate": certificate},
}


def write(names: Iterable[str]) -> None:
    cases = json.loads(FILE.read_text()).get("cases", {}) if FILE.exists() else {}
    cases = {name: CASES[name]() if name in names else cases[name] for name in CASES}
    FILE.write_text(json.dumps({"cases": cases, "versions": versions()}, indent=1) + "\n")


if __name__ == "__main__":
    write(sys.argv[1:] or CASES)
