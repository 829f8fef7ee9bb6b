"""Every public name, with one argument of a wrong kind at a time: one sentence of the planner's, or it is taken.

A new public function or method fails here until it has a row of arguments that are right.
"""

# pyright: reportArgumentType=false
from __future__ import annotations

import enum
import inspect
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import planner
from planner import gabf
from planner.base.errors import PlannerError
from planner.base.kinds import kinds_of
from planner.models.files.robot_files import JointChoice
from planner.tasks.file import Move
from planner.tradeoff.sweep import Tradeoff
from planner.trajectory.time_shortcuts import joint_motion
from tests.tasks import cases
from tests.worlds import load, make_post, post_roadmap

WRONG: dict[str, object] = {
    "None": None,
    "text": "x",
    "three": 3,
    "nan": np.nan,
    "shape": np.ones((2, 3, 1)),
    "empty": [],
    "objects": [object()],
    "infinite": np.inf,
    "itself": planner,
    "beyond all floats": 10**400,
}
CALLED_BY_SOLVE = {"bind", "states", "steps", "targets", "wants", "block_of_row"}
RESULTS = {  # nobody but the planner makes these
    "Plan", "TaskPlan", "ToolPath", "Tradeoff", "Trajectory", "Verdict", "Robot", "Reason", "Roadmap",
    "CollisionChecker", "Change",
    "gabf.CostToGo", "gabf.Certificate",
    "gabf.Assumption", "gabf.Healing", "gabf.Structure", "gabf.Premises", "gabf.FieldHistory",
}  # fmt: skip
INSIDE = {
    "Objective.total", "ToolPath.at", "ToolPath.divided", "ToolPath.rows", "Roadmap.edge_index",
    "Roadmap.part", "Roadmap.record", "Roadmap.without_edge",
    "Trajectory.at_nanoseconds", "Trajectory.on", "Trajectory.piece_at", "Trajectory.worst",
}  # fmt: skip
ELSEWHERE = {"CollisionChecker"}  # its methods have tests/test_arrays_refused.py
KEYWORDS = {"options", "more"}  # of functions that hand them on
FINE = np.array([[-1.0, 0.8], [-1.1, 0.9], [-1.0, 1.0]])
EYE = np.eye(4)


@cache
def robot() -> planner.Robot:
    return load("planar_2r")


def scene() -> planner.Scene:
    return planner.Scene("x", (planner.Obstacle("box", planner.Box((0.1, 0.1, 0.1)), planner.pose([0, 0, 3])),))


def net() -> gabf.Network:
    return gabf.Network.from_arcs([1, 2, 2], [0, 0, 1], np.ones(3), [0], 3, node_cost=np.ones(3))


@cache
def field() -> gabf.CostToGo:
    return gabf.solve(net())


@cache
def small_plan() -> planner.Plan:
    return planner.plan(**PLAN, start=FINE[0], goal=FINE[1])


@cache
def small_sweep() -> Tradeoff:
    return planner.sweep(planner.SweepRequest(**PLAN, start=FINE[0], goal=FINE[1]))


def session() -> planner.Session:
    made = planner.Session(robot(), scene(), nodes=4)
    made.plan(FINE[0], FINE[1])
    return made


@cache
def motion() -> planner.Trajectory:
    return planner.time_path(FINE, make_post(), law="blended")


def known() -> planner.KnownMotion:
    return planner.KnownMotion([0, 4], [planner.pose([1, -1, 0.5]), planner.pose([1, 1, 0.5])])


PLAN: dict[str, Any] = {"robot": "planar_2r", "scene": "empty", "nodes": 4, "effort": 0}
LINE = {"points": [{"position": [x, 0.5, 0.0], "axis": [0, 0, 1]} for x in (0.5, 0.6)]}
SPHERE = planner.Sphere(0.1)
TRIANGLE = {"vertices": np.eye(3), "triangles": np.array([[0, 1, 2]])}
X = np.zeros(3)

# of functions and of what makes a thing: arguments that are right, made anew every time
CALLS: dict[str, Callable[[], dict[str, Any]]] = {
    "Box": lambda: {"size": (1.0, 1.0, 1.0)},
    "Capsule": lambda: {"radius": 0.1, "length": 0.1},
    "Cylinder": lambda: {"radius": 0.1, "length": 0.1},
    "Sphere": lambda: {"radius": 0.1},
    "Mesh": lambda: {**TRIANGLE, "radius": 0.0},
    "Obstacle": lambda: {
        "name": "a", "shape": SPHERE, "placement": EYE, "part_of": None, "speed_limit": 0.0, "frame": ""
    },
    "Gate": lambda: {
        "robot": robot(), "scene": scene(), "limits": planner.MotionLimits.of(robot()), "judged": ("velocity",),
        "min_manipulability": 0.0, "margin": 0.0, "start_tolerance": 0.01, "tool": None, "collision": "fcl",
        "keep": None,
    },
    "KnownMotion": lambda: {"times": [0.0, 1.0], "poses": [EYE, EYE]},
    "MovingObstacle": lambda: {"name": "a", "shape": SPHERE, "motion": known()},
    "KeepAxis": lambda: {"axis": "z", "direction": (0.0, 0.0, 1.0), "angle": 0.1, "frame": None},
    "KeepBox": lambda: {"lower": (0.0, 0.0, 0.0), "upper": (1.0, 1.0, 1.0), "point": (0.0, 0.0, 0.1), "frame": None},
    "KeepEuler": lambda: {"tolerances": (0.1, 0.1, 0.1), "quaternion": None, "frame": None},
    "KeepJoint": lambda: {"joint": "a", "lower": 0.0, "upper": 1.0, "frame": None},
    "KeepPlane": lambda: {"normal": (0.0, 0.0, 1.0), "distance": 0.1, "point": (0.0, 0.0, 0.1), "frame": None},
    "KeepRotationVector": lambda: {"tolerances": (0.1, 0.1, 0.1), "quaternion": None, "frame": None},
    "KeepSphere": lambda: {"centre": (0.0, 0.0, 1.0), "radius": 0.1, "point": (0.0, 0.0, 0.1), "frame": None},
    "KeepTurn": lambda: {"angle": 0.1, "quaternion": (0.0, 0.0, 0.0, 1.0), "frame": None},
    "ToolGoal": lambda: {"conditions": (planner.KeepSphere((0.0, 0.0, 1.0)),)},
    "Objective": lambda: {name: getattr(planner.Objective(), name) for name in planner.Objective.__dataclass_fields__},
    "LimitsRequest": lambda: dict(vars(planner.LimitsRequest())),
    "TimingRequest": lambda: dict(vars(planner.TimingRequest())),
    "FollowRequest": lambda: dict(vars(planner.FollowRequest())),
    "PlanRequest": lambda: dict(vars(planner.PlanRequest())),
    "SweepRequest": lambda: dict(vars(planner.SweepRequest())),
    "Progress": lambda: {"report": print, "stop": bool},
    "MotionLimits": lambda: dict(vars(planner.MotionLimits.of(robot()))),
    "Scene": lambda: {
        "name": "x", "obstacles": scene().obstacles, "moving": (), "carried": (), "states": {},
        "description": "", "robots": {}, "allowed": frozenset(), "message": None, "notes": (), "keep": "",
    },
    "Session": lambda: {
        "robot": robot(), "scene": scene(), "roadmap": None, "tool": None, "collision": "fcl", "margin": 0.0,
        "nodes": 4, "seed": 0, "law": "singularity-free", "prescribed_time": 4.0, "metric": "joint",
        "manipulability_cost": "log", "charge": "edges", "join_motions": None, "objective": None,
    },
    "check": lambda: {"what": FINE, "checker": make_post(), "step": 0.001, "progress": planner.Progress()},
    "export": lambda: {"trajectory": motion(), "kind": "csv", "skip_first_point": False},
    "build_network": lambda: {"roadmap": post_roadmap(), "objective": 0.5, "clearance": 0.0, "beta": None},
    "build_roadmap": lambda: {
        "robot": make_post().robot, "checker": make_post(), "start": FINE[0], "goal": FINE[1], "nodes": 4, "seed": 0,
        "progress": planner.Progress(), "min_manipulability": 0.0, "density": 2.0, "refined": 0.1, "growth": None,
    },
    "load_roadmap": lambda: {"path": "none.npz"},
    "save_roadmap": lambda: {"roadmap": post_roadmap(), "path": "/nonexistent/x.npz"},
    "make_checker": lambda: {"robot": robot(), "scene": scene(), "backend": "fcl", "margin": 0.0, "keep": ()},
    "paths_from": lambda: {"network": net(), "cost_to_go": field(), "starts": [1]},
    "plan": lambda: {
        "request": None, "progress": planner.Progress(), "timing": None, **PLAN, "start": FINE[0], "goal": FINE[1],
        "beta": 0.5, "collision": "fcl", "tool": None, "joints": None, "seed": 0, "roadmap": None, "objective": None,
    },
    "follow": lambda: {
        "tool_path": LINE, "request": None, "progress": planner.Progress(), "timing": None, "robot": "planar_2r",
        "scene": "empty", "beta": 0.5, "tool_speed": None, "ladder_density": 1,
    },
    "read_tool_path": lambda: {"path": LINE},
    "pose": lambda: {"position": [0, 0, 0], "rpy": None, "quaternion": [0, 0, 0, 1]},
    "show": lambda: {"thing": small_plan(), "checker": None, "height": 100},
    "sweep": lambda: {
        "request": planner.SweepRequest(**PLAN, start=FINE[0], goal=FINE[1]), "progress": planner.Progress(),
        "front": False, "max_labels": 10, "earlier": None,
    },
    "Task": lambda: {
        "robot": "panda", "scene": cases.SCENE, "steps": cases.SMALL.steps, "start": "home",
        "gripper": cases.SMALL.gripper, "name": "x",
    },
    "TaskRequest": lambda: dict(vars(planner.TaskRequest())),
    "task": lambda: {
        "what": cases.TINY, "progress": planner.Progress(), "timing": None, "request": None, "nodes": 4, "seed": 0,
    },
    "time_path": lambda: {
        "path": FINE, "checker": make_post(), "limits": None, "law": "blended", "deviation": 0.1,
        "floor": 0.0, "cost": joint_motion, "extra_cost": 0.0,
    },
    "gabf.AtTimes": lambda: {"t": [0.0, 1.0]},
    "gabf.BackwardEuler": lambda: {"step": 0.05},
    "gabf.EdgeIntegral": lambda: {"beta": 0.5},
    "gabf.EverySteps": lambda: {"k": 1},
    "gabf.FixedTime": lambda: dict(vars(gabf.FixedTime())),
    "gabf.Multiplicative": lambda: {"K": None},
    "gabf.Network": lambda: {
        "indptr": [0, 0, 1], "indices": [0], "weight": [1.0], "sources": [0], "source_values": None, "node_cost": None,
        "arc_cost": None, "kernel": gabf.Additive(),
    },
    "gabf.Nominal": lambda: {"eta": 1.0},
    "gabf.Partition": lambda: {"blocks": 2, "scheduler": None, "assignment": None},
    "gabf.PrescribedTime": lambda: dict(vars(gabf.PrescribedTime())),
    "gabf.RungeKutta45": lambda: {"rtol": 1e-6, "atol": 1e-9, "max_step": np.inf},
    "gabf.SingularityFree": lambda: dict(vars(gabf.SingularityFree())),
    "gabf.Splitting": lambda: {"tolerance": 0.05, "max_step": np.inf},
    "gabf.TradeOff": lambda: {"beta": 0.5},
    "gabf.UserKernel": lambda: {"f": lambda x, w: x + w, "lower": 0.0, "upper": 10.0},
    "gabf.T_star_corrected": lambda: {"law": gabf.FixedTime()},
    "gabf.T_star_printed": lambda: {"law": gabf.FixedTime()},
    "gabf.T_star_sharp": lambda: {"law": gabf.FixedTime()},
    "gabf.bellman_operator": lambda: {"net": net(), "x": X},
    "gabf.certify": lambda: {"net": net(), "law": field().law, "result": field(), "optimum": None},
    "gabf.cheapest_path": lambda: {"result": field(), "starts": [1]},
    "gabf.control_input": lambda: {"law": gabf.Nominal(), "tau": 0.1, "xhat": X},
    "gabf.extract_path": lambda: {"net": net(), "result": field(), "start": 1},
    "gabf.heal": lambda: {"net": net(), "x": X, "law": gabf.SingularityFree(), "since_tau": 0.0},
    "gabf.max_error": lambda: {"result": field(), "x_star": X},
    "gabf.named_law": lambda: {"name": "nominal", "T": 4.0},
    "gabf.oracle": lambda: {"net": net()},
    "gabf.overestimate": lambda: {"net": net()},
    "gabf.raised_start": lambda: {"net": net(), "x": X},
    "gabf.read_network": lambda: {"path": "none.npz", "kernel": gabf.Additive()},
    "gabf.residual": lambda: {"net": net(), "x": X},
    "gabf.right_side": lambda: {"net": net(), "law": gabf.Nominal()},
    "gabf.solve": lambda: {
        "net": net(), "law": gabf.SingularityFree(), "x0": None, "solver": gabf.Splitting(), "save": None,
        "settle_tolerance": 1e-9, "max_steps": 1000, "until_tau": np.inf, "partition": None,
    },
    "gabf.structure": lambda: {"net": net(), "x_star": None},
    "gabf.true_parents": lambda: {"net": net(), "optimum": gabf.structure(net()), "i": 1},
    "gabf.value_iteration": lambda: {"net": net(), "x0": X, "max_sweeps": 10},
    "gabf.write_network": lambda: {"network": net(), "path": "/nonexistent/x.npz"},
}  # fmt: skip

THINGS: dict[str, Callable[[], Any]] = {
    "Gate": lambda: planner.Gate(robot(), scene()),
    "KnownMotion": known,
    "MotionLimits": lambda: planner.MotionLimits.of(robot()),
    "MovingObstacle": lambda: planner.MovingObstacle("a", SPHERE, known()),
    "Objective": planner.Objective,
    "Plan": small_plan,
    "Progress": planner.Progress,
    "Robot": robot,
    "Scene": scene,
    "Session": session,
    "Task": lambda: cases.SMALL,
    "TaskPlan": lambda: cases.small().plan(),
    "Tradeoff": small_sweep,
    "FollowRequest": lambda: planner.FollowRequest(),
    "PlanRequest": lambda: planner.PlanRequest(),
    "SweepRequest": lambda: planner.SweepRequest(),
    "Trajectory": motion,
    "gabf.CostToGo": field,
    "gabf.Network": net,
}
METHODS: dict[str, Callable[[], dict[str, Any]]] = {
    "Gate.check": lambda: {
        "positions": FINE, "velocities": 0 * FINE, "accelerations": 0 * FINE, "times": [1.0, 2.0, 3.0],
        "state": (FINE[0], 0 * FINE[0]), "stop": True,
    },
    "Gate.move": lambda: {"name": "box", "pose": planner.pose([0, 0, 5])},
    "Gate.add": lambda: {"obstacle": planner.Obstacle("new", SPHERE, planner.pose([0, 0, 4]))},
    "Gate.remove": lambda: {"name": "box"},
    "Gate.attach": lambda: {"name": "box", "frame": robot().tool, "at": FINE[0], "touch_links": ()},
    "Gate.detach": lambda: {"name": "box", "at": FINE[0]},
    "KnownMotion.at": lambda: {"t": 0.5},
    "KnownMotion.speeds": lambda: {"shape": SPHERE},
    "KnownMotion.speeds_at": lambda: {"t": np.array([0.5]), "shape": SPHERE},
    "MotionLimits.of": lambda: {"robot": robot(), "request": None},
    "MotionLimits.given": lambda: {"kind": "jerk"},
    "MotionLimits.times": lambda: {"share": 0.5},
    "MovingObstacle.standing": lambda: {"t": 0.5},
    "Objective.at": lambda: {"beta": 0.5},
    "Plan.save": lambda: {"folder": "/nonexistent/x", "certificate": False},
    "Task.load": lambda: {"path": "none.yaml"},
    "TaskPlan.check": lambda: {"step": 0.1},
    "TaskPlan.save": lambda: {"folder": "/nonexistent/x"},
    "Tradeoff.save": lambda: {"folder": "/nonexistent/x"},
    "Progress.renamed": lambda: {"report": print},
    "Robot.load": lambda: {
        "name": "planar_2r", "tool": None, "fixed_joints": None, "base": None, "srdf": None, "choice": JointChoice()
    },
    "Robot.difference": lambda: {"a": FINE[0], "b": FINE[1]},
    "Robot.told_by_ends": lambda: {"delta": FINE},
    "Robot.unwound": lambda: {"path": FINE},
    "Robot.normalise": lambda: {"q": FINE},
    "Scene.load": lambda: {"name": "empty"},
    "Scene.placement": lambda: {"robot": "iiwa14"},
    "Scene.states_of": lambda: {"robot": "iiwa14"},
    "Session.restore": lambda: {"snapshot": session().snapshot()},
    "Session.add": lambda: {"obstacle": planner.Obstacle("new", SPHERE, planner.pose([0, 0, 4]))},
    "Session.move": lambda: {"name": "box", "position": [0, 0, 5], "rpy": None, "quaternion": [0, 0, 0, 1]},
    "Session.remove": lambda: {"name": "box"},
    "Session.attach": lambda: {"name": "box", "frame": robot().tool, "touch_links": (), "at": FINE[0]},
    "Session.detach": lambda: {"name": "box", "at": FINE[0]},
    "Session.plan": lambda: {"start": FINE[0], "goal": FINE[1], "beta": 0.5, "progress": planner.Progress()},
    "Session.task": lambda: {
        "what": (Move("home"),), "start": FINE[0], "progress": planner.Progress(), "timing": None, "nodes": 4,
    },
    "Session.replan": lambda: {"progress": planner.Progress()},
    "Session.plan_in_time": lambda: {"start": FINE[0], "goal": FINE[1], "limits": None},
    "FollowRequest.objective_at": lambda: {"beta": 0.5},
    "PlanRequest.objective_at": lambda: {"beta": 0.5},
    "SweepRequest.objective_at": lambda: {"beta": 0.5},
    "Trajectory.through": lambda: {
        "joints": robot().joints, "times": [0.0, 1.0, 2.0], "q": FINE, "qd": 0 * FINE, "qdd": None, "law": "given"
    },
    "Trajectory.at": lambda: {"t": 0.5, "order": 0},
    "Trajectory.knots": lambda: {"order": 0},
    "Trajectory.ends": lambda: {"order": 0},
    "Trajectory.extrema": lambda: {"order": 0},
    "Trajectory.largest": lambda: {"order": 0},
    "Trajectory.stop_at": lambda: {"t": 0.1, "checker": None},
    "gabf.CostToGo.settling_within": lambda: {"width": 0.5},
    "gabf.CostToGo.dated_within": lambda: {"width": 0.5},
    "gabf.Network.from_arcs": lambda: {
        "tails": [1], "heads": [0], "weight": [1.0], "sources": [0], "n_nodes": 2, "arc_cost": [1.0],
        "kernel": gabf.Additive(),
    },
    "gabf.Network.arcs_along": lambda: {"nodes": [1, 0]},
    "gabf.Network.arcs_between": lambda: {"i": 1, "j": 0},
    "gabf.Network.without_arcs": lambda: {"arcs": [0]},
}  # fmt: skip

JUDGED_INSIDE = {
    "Gate": {"keep"},
    "FollowRequest": {"start", "goal", "keep"},
    "PlanRequest": {"start", "goal", "keep"},
    "Scene": {"message"},
    "Session.attach": {"at"},
    "Session.detach": {"at"},
    "Session.plan": {"start", "goal"},
    "Session.task": {"start"},
    "Session.plan_in_time": {"start", "goal"},
    "SweepRequest": {"start", "goal", "keep"},
    "Trajectory.stop_at": {"checker"},
}
REFUSED_ALWAYS = {
    "Gate.detach",
    "Session.restore",
    "Session.detach",
    "load_roadmap",
    "save_roadmap",
    "gabf.read_network",
    "gabf.write_network",
    "Plan.save",
    "Task.load",
    "TaskPlan.save",
    "Tradeoff.save",
}


def public() -> Iterator[tuple[str, Any]]:
    """Every public name, and what users get from them."""
    for module, prefix in ((planner, ""), (gabf, "gabf.")):
        for name in module.__all__:
            yield prefix + name, getattr(module, name)


def callables() -> Iterator[tuple[str, Callable[..., Any], bool]]:
    """Names, what is called, and whether that is a method (or belongs to a class)."""
    for name, thing in public():
        if isinstance(thing, ModuleType | str):
            continue
        if not inspect.isclass(thing):
            yield name, thing, False
            continue
        if issubclass(thing, enum.Enum | Exception):
            continue
        if name not in RESULTS and inspect.signature(thing).parameters:
            yield name, thing, False
        for method, member in inspect.getmembers(thing, callable):
            inside = method in CALLED_BY_SOLVE or f"{name}.{method}" in INSIDE or name in ELSEWHERE
            if not method.startswith("_") and not inside and _parameters(member):
                yield f"{name}.{method}", member, True


def _parameters(function: Callable[..., Any]) -> list[str]:
    return [name for name in inspect.signature(function).parameters if name != "self"]


NAMES = {name: (called, is_method) for name, called, is_method in callables()}


def arguments(name: str) -> dict[str, Any]:
    return (METHODS if NAMES[name][1] else CALLS)[name]()


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where what is saved as "x" is in nobody's way."""
    monkeypatch.chdir(tmp_path)


def test_every_public_name_has_its_row() -> None:
    assert set(NAMES) == set(CALLS) | set(METHODS)
    for name, (called, _) in NAMES.items():
        assert set(_parameters(called)) - KEYWORDS <= set(arguments(name)), name


@pytest.mark.parametrize("name", NAMES)
def test_kinds_are_checked(name: str) -> None:
    called = NAMES[name][0]
    function = called.__init__ if inspect.isclass(called) else called
    assert hasattr(function, "__wrapped__"), "decorate it with checks_kinds"
    loose = {parameter for parameter, kind in kinds_of(function).items() if kind is None}
    assert loose <= JUDGED_INSIDE.get(name, set())


@pytest.mark.parametrize("name", NAMES)
def test_right_arguments_are_taken(name: str) -> None:
    try:
        _call(name, arguments(name))
    except PlannerError:
        assert name in REFUSED_ALWAYS


@pytest.mark.parametrize("name", NAMES)
def test_wrong_kinds_end_in_a_sentence(name: str) -> None:
    found = {}
    for parameter in arguments(name):
        for what, value in WRONG.items():
            try:
                _call(name, arguments(name) | {parameter: value})
            except PlannerError as error:
                text = str(error)
                if (
                    not 10 < len(text) < 500
                    or "\n" in text
                    or not any(mark in text for mark in (":", ";", ",", " must "))
                ):
                    found[parameter, what] = text
            except Exception as error:
                found[parameter, what] = repr(error)[:150]
    assert found == {}


@pytest.mark.parametrize("name", NAMES)
def test_numbers_of_numpy_are_taken_as_pythons_own(name: str) -> None:
    twins = {bool: np.bool_, int: np.int64, float: np.longdouble}
    given = {what: twins[type(value)](value) for what, value in arguments(name).items() if type(value) in twins}
    if name in REFUSED_ALWAYS or not given:
        return
    _call(name, arguments(name) | given)
    if inspect.isclass(made := NAMES[name][0]):
        kept = vars(made(**(arguments(name) | given))).items()
        assert [what for what, value in kept if isinstance(value, np.generic)] == []


def _is_sentence(text: str) -> bool:
    """What is wrong, and what to do, or what it must be."""
    return 10 < len(text) < 500 and "\n" not in text and any(mark in text for mark in (":", ";", ",", " must "))


def _call(name: str, given: dict[str, Any]) -> object:
    called, is_method = NAMES[name]
    if is_method:
        thing, method = name.rsplit(".", 1)
        called = getattr(THINGS[thing](), method)
    return called(**given)
