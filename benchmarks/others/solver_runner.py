"""Another planner on one problem, run by the Python of its own environment: nothing of this package is imported.

python -I solver_runner.py roboplan problem.json answer.json

The problem is what :mod:`benchmarks.others.exchange` writes. The answer holds ``path``, a list of
configurations or null, ``version``, and the seconds of the wall clock: ``ready_s`` to add the obstacles to a robot that
is loaded, ``first_s`` to a path, ``path_s`` to the path after shortcuts. That of "hpp proofs" says which of the
problem's ``motions`` HPP proves.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.metadata
import itertools
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

STEP = 0.05  # rad between two states that are checked: the default
_MOST_NODES = 1_000_000
HPP_TOLERANCES = {"Dichotomy": 0.0, "Progressive": 1e-4}  # m that bodies may penetrate; the second needs some
_CONNECTION = 3.0  # rad: roboplan's default


def solve_by_roboplan(problem: dict[str, Any]) -> dict[str, Any]:
    """RRT-Connect and shortcuts of roboplan, a C++ library."""
    core, rrt = importlib.import_module("roboplan.core"), importlib.import_module("roboplan.rrt")
    scene = core.Scene("bench", core.loadUrdfSceneDescriptionFromXml(problem["urdf"], problem["package_dirs"]))
    scene.addGroup("arm", problem["joints"])
    scene.setCollisions([tuple(pair) for pair in problem["free_pairs"]], False)
    whole = scene.getCurrentJointPositions().copy()
    for name, value in problem["held"].items():
        whole[scene.getJointPositionIndices([name])] = value
    scene.setJointPositions(whole)
    clock = _Clock()
    for item in problem["obstacles"]:
        shape = {
            "box": lambda item=item: core.Box(*item["size"]),
            "sphere": lambda item=item: core.Sphere(item["radius"]),
            "cylinder": lambda item=item: core.Cylinder(item["radius"], item["length"]),
        }[item["type"]]()
        add = {"box": scene.addBoxGeometry, "sphere": scene.addSphereGeometry, "cylinder": scene.addCylinderGeometry}
        placement = np.asfortranarray(item["placement"], dtype=float)
        add[item["type"]](item["name"], "universe", shape, placement, np.ones(4))
    standing = itertools.combinations([item["name"] for item in problem["obstacles"]], 2)
    scene.setCollisions(list(standing), False)
    options = rrt.RRTOptions(
        group_name="arm",
        max_nodes=_MOST_NODES,
        max_connection_distance=_CONNECTION,
        collision_check_step_size=STEP,
        max_planning_time=problem["seconds"],
        rrt_connect=True,
    )
    planner = rrt.RRT(scene, options)
    planner.setRngSeed(problem["seed"])
    ends = [core.JointConfiguration(problem["joints"], np.array(problem[end])) for end in ("start", "goal")]
    clock.lap("ready_s")
    found = planner.plan(*ends)
    clock.lap("first_s")
    short = core.PathShortcuttingOptions(group_name="arm", max_step_size=STEP, seed=problem["seed"])
    path = core.PathShortcutter(scene, short).shortcut(found)
    clock.lap("path_s")
    order = [path.joint_names.index(name) for name in problem["joints"]] if path.joint_names else slice(None)
    return {"path": [np.asarray(q)[order].tolist() for q in path.positions], **clock.seconds}


def solve_by_hpp(problem: dict[str, Any]) -> dict[str, Any]:
    """BiRRTPlanner and RandomShortcut of HPP, a C++ library, every motion proven by dichotomy without a tolerance."""
    core = importlib.import_module("pyhpp.core")
    arm = _HppArm(problem)
    clock = _Clock()
    arm.add(problem["obstacles"])
    asked = core.Problem(arm.device)
    validation = core.Dichotomy(arm.device, 0.0)
    asked.pathValidation(validation)  # a call: an assignment is passed over, and samples are checked
    asked.initConfig(arm.state(problem["start"]))
    asked.addGoalConfig(arm.state(problem["goal"]))
    planner, shortcuts = core.BiRRTPlanner(asked), core.RandomShortcut(asked)
    planner.maxIterations(_MOST_NODES)
    planner.timeOut(problem["seconds"])
    clock.lap("ready_s")
    found = planner.solve()
    clock.lap("first_s")
    found = shortcuts.optimize(found)
    clock.lap("path_s")
    pieces = [found.pathAtRank(k) for k in range(found.numberPaths())]
    path = [arm.planned(q) for q in (pieces[0].initial(), *(piece.end() for piece in pieces))]
    return {"path": path, "proven": True, **clock.seconds}


def proofs_of_hpp(problem: dict[str, Any]) -> dict[str, Any]:
    """What HPP proves of straight motions, ``motions`` (m, 2, dof), by both its methods, and the seconds of each."""
    core = importlib.import_module("pyhpp.core")
    arm = _HppArm(problem)
    arm.add(problem["obstacles"])
    asked = core.Problem(arm.device)
    paths = [asked.directPath(*map(arm.state, ends), False)[1] for ends in problem["motions"]]
    found: dict[str, Any] = {}
    for name, tolerance in HPP_TOLERANCES.items():
        validation = getattr(core, name)(arm.device, tolerance)
        begin = time.perf_counter()
        found[name] = [bool(validation.validate(path, False)[0]) for path in paths]
        found[f"{name}_s"] = time.perf_counter() - begin
    return found


class _HppArm:
    """HPP's robot without the joints that are not planned, and the pairs of its links that are checked.

    All is loaded as URDF and SRDF: HPP writes past its arrays for what is put into its geometry afterwards. Joints are
    removed: with bounds of no width in their place it proves motions that touch by a centimetre.
    """

    def __init__(self, problem: dict[str, Any]) -> None:
        os.environ["ROS_PACKAGE_PATH"] = os.pathsep.join(problem["package_dirs"])
        self.device = importlib.import_module("pyhpp.pinocchio").Device("robot")
        pairs = "".join(f'<disable_collisions link1="{a}" link2="{b}"/>' for a, b in problem["free_pairs"])
        self._load("", problem["urdf"], f'<robot name="robot">{pairs}</robot>')
        whole = self.device.model()
        q = np.zeros(whole.nq)
        for name, value in problem["held"].items():
            q[whole.joints[whole.getJointId(name)].idx_q] = value
        if problem["held"]:
            self.device.removeJoints(list(problem["held"]), q)
        model = self.device.model()
        self._rank = [model.joints[model.getJointId(name)].idx_q for name in problem["joints"]]

    def add(self, obstacles: list[dict[str, Any]]) -> None:
        """Obstacles, as a model without joints."""
        shapes = "".join(map(_urdf_collision, obstacles))
        self._load("scene", f'<robot name="scene"><link name="obstacles">{shapes}</link></robot>', "")

    def _load(self, prefix: str, urdf: str, srdf: str) -> None:
        pin, loader = importlib.import_module("pinocchio"), importlib.import_module("pyhpp.pinocchio.urdf")
        loader.loadModelFromString(self.device, 0, prefix, "anchor", urdf, srdf, pin.SE3.Identity())

    def state(self, q: list[float]) -> Any:
        """HPP's configuration where the planned joints are at ``q``."""
        found = np.zeros(len(q))
        found[self._rank] = q
        return found

    def planned(self, q: Any) -> list[float]:
        """The planned joints of a configuration of HPP's."""
        return np.asarray(q)[self._rank].tolist()


def _urdf_collision(item: dict[str, Any]) -> str:
    """An obstacle as a collision shape of a link."""
    placement = np.array(item["placement"])
    angles = importlib.import_module("pinocchio").rpy.matrixToRpy(placement[:3, :3])
    sizes = {"box": {"size": item.get("size")}, "sphere": {"radius": [item.get("radius")]}}
    sizes["cylinder"] = {"radius": [item.get("radius")], "length": [item.get("length")]}
    words = " ".join(f'{key}="{_numbers(value)}"' for key, value in sizes[item["type"]].items())
    origin = f'<origin xyz="{_numbers(placement[:3, 3])}" rpy="{_numbers(angles)}"/>'
    return f'<collision name="{item["name"]}">{origin}<geometry><{item["type"]} {words}/></geometry></collision>'


def _numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)


SOLVERS = {
    "roboplan": solve_by_roboplan,
    "hpp": solve_by_hpp,
    "hpp proofs": proofs_of_hpp,
}
_PACKAGES = {"hpp": "hpp-python", "hpp proofs": "hpp-python"}  # where they have another name


class _Clock:
    """Seconds since the last lap, by name; those of ``path_s`` count from the end of ``ready_s``."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._begin = time.perf_counter()

    def lap(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = now - self._begin
        if name == "ready_s":
            self._begin = now


def main(method: str, problem: str, answer: str) -> None:
    """Solve and write the answer; what the planner itself refuses is an answer without a path."""
    asked = json.loads(Path(problem).read_text())
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        try:
            found = SOLVERS[method](asked)
        except RuntimeError as error:
            found = {"path": None, "message": str(error)}
    said = {"version": importlib.metadata.version(_PACKAGES.get(method, method)), "proven": False, **found}
    Path(answer).write_text(json.dumps(said))


if __name__ == "__main__":
    main(*sys.argv[1:])
