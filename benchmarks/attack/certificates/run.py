"""The cost of a plan's certificate, and changed certificates, of which no false one may be accepted."""

from __future__ import annotations

import json
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.attack.certificates.folders import AROUND, folder_of
from benchmarks.attack.certificates.judge import beyond_limits, closest, least_w
from benchmarks.attack.certificates.mutations import Case, Data, climb_witnesses, largest, mutate
from planner.certificate import PROOF_NAME, verify
from planner.certificate.certificate import require_same_world
from planner.certificate.geometry import extract_geometry
from planner.certificate.verify_proof import Refused
from planner.collision import make_checker
from planner.collision.world import World
from planner.planning.plan import plan
from planner.problem.request import PlanRequest, TimingRequest
from planner.robot.poses import pose
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Obstacle
from planner.trajectory.timing import time_path

ROBOTS, SCENES = ("iiwa14", "panda", "ur5"), ("shelf", "table")
MARGIN = 0.005  # m, of the path whose certificate is changed: what is nearer is a counterexample
FLOOR = 0.09  # m^2, of the path whose least w is 0.097
CHUNK = 50  # certificates, of which one is the largest change in its direction that is accepted, and one a climb
_MOTIONS = 0.1  # the share of motions, which take longer to judge
_SAMPLES = 3  # configurations of each piece that an accepted certificate is judged by


def certify(robot: str, scene: str, seed: int) -> dict[str, Any]:
    """Seconds of computing of a plan, of saving it with a certificate and of checking that; its size and verdict."""
    began = time.process_time()
    found = plan(request=PlanRequest.from_options(robot=robot, scene=scene, seed=seed), timing=TimingRequest())
    plan_s = time.process_time() - began
    if not found.solved:
        return {"verdict": found.message}
    with tempfile.TemporaryDirectory() as name:
        place, began = Path(name), time.process_time()
        found.save_without_page(place, certificate=True)
        certify_s = time.process_time() - began
        made, began = len(Case.from_folder(place).data["piece"]), time.process_time()
        try:
            verdict = verify(place, found.checker.world).partition(":")[0].lower()
        except Refused as why:
            verdict = str(why)
        check_s, size = time.process_time() - began, (place / PROOF_NAME).stat().st_size
    columns = {"plan_s": plan_s, "certify_s": certify_s, "check_s": check_s, "size": size}
    return columns | {"witnesses": made, "verdict": verdict, "tried": 1}


def change(chunk: int, seed: int) -> dict[str, Any]:
    """Counts of a chunk of changed certificates and of those accepted, by kind, and the false ones among these."""
    found = _try_changes(_cases(seed)[1], np.random.default_rng([seed, chunk]))
    return {
        "tried": CHUNK,
        "free": sum(accepted for _, accepted in found["counts"].values()),
        "false_free": len(found["false"]),
        "counts": json.dumps(found["counts"]),
        "found": json.dumps(found["false"]) if found["false"] else "",
    }


@cache
def _cases(seed: int) -> tuple[tempfile.TemporaryDirectory, list[tuple[Case, World, float]]]:
    """A path and a motion of few pairs, checked in milliseconds; with the margin (m) that they do not keep."""
    place = tempfile.TemporaryDirectory()
    scene = Scene("post", (Obstacle("post", Box((0.1, 0.02, 0.2)), pose([0.75, 0.0, 0.0])),))
    checker, made = make_checker(Robot.load("planar_2r"), scene, margin=MARGIN), []
    for name, motion in (("path", None), ("motion", time_path(AROUND, checker, time_law="shortcuts"))):
        case = Case.from_folder(folder_of(Path(place.name) / name, checker, AROUND, motion, FLOOR)[0])
        made.append((case, checker.world, closest(case.data, 200, np.random.default_rng(seed), 1.0)))
    return place, made


def _try_changes(cases: list[tuple[Case, World, float]], rng: np.random.Generator) -> dict[str, Any]:
    """Counts of what was changed and of what was accepted, by kind, and what is false of that."""
    counts, false = dict[str, list[int]](), list[str]()
    for k in range(CHUNK):
        case, world, near = cases[int(rng.random() < _MOTIONS)]
        if k == 0:
            data, kind = largest(case, rng) or (None, "")
            kind, words = "the largest change that is accepted", case.meta
        elif k == 1:
            data, words = climb_witnesses(case, rng, near + 10.0 ** rng.uniform(-9, -4))
            data, kind = data if case.accepts(data, words) else None, "witnesses raised beyond the true distance"
            false += [kind] if data is not None else []
        else:
            data, words, kind = mutate(case, rng)
            data = data if case.accepts(data, words, follow := bool(rng.random() < 0.5)) else None
            if data is not None and not follow and not _same(data, case.data, ("path", "clock", "knots", "limits")):
                false.append(f"{kind}: not what is in the folder")
        counts[kind] = [a + b for a, b in zip(counts.get(kind, [0, 0]), (1, int(data is not None)), strict=True)]
        if data is not None:
            false += [f"{kind}: {what}" for what in _false_claims(case, data, words, world, rng)]
    return {"counts": counts, "false": false}


def _false_claims(case: Case, data: Data, words: dict[str, Any], world: World, rng: np.random.Generator) -> list[str]:
    """What is not true of a certificate that was accepted; and whether it passes as one of another world's."""
    found = ["too close"] if closest(data, _SAMPLES, rng, MARGIN) < MARGIN - 1e-7 else []
    found += ["below the floor"] if least_w(data, words, _SAMPLES) < data["floor"] - 1e-9 else []
    found += ["beyond limits"] if beyond_limits(data) > 2e-6 else []
    try:
        require_same_world(case.folder / PROOF_NAME, world)
    except Refused:
        return found
    same = words == case.meta and _same(data, case.data, tuple(extract_geometry(world)))
    return found + ([] if same else ["of another world"])


def _same(one: Data, two: Data, names: tuple[str, ...]) -> bool:
    return all(np.array_equal(one[name], two[name]) for name in names)
