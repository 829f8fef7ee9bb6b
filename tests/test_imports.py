"""The house: imports point downwards, libraries have one door, and nothing heavy loads early."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent
PACKAGES = tuple(TESTS.parent / name for name in ("planner", "reproduce", "benchmarks"))

# the rooms of the house, floor by floor: a room sees itself and the floors below
FLOORS: tuple[tuple[str, ...], ...] = (
    ("base",),
    ("native", "problem"),
    ("kinematics", "gabf"),  # gabf sees base and what is compiled of dynamics and graphs: it knows no robot
    ("robot",),
    ("constraints",),
    ("collision", "cost"),
    ("query",),
    ("roadmap",),
    ("trajectory",),
    ("certificate", "tool_paths"),
    ("view", "search"),
    ("planning",),
    ("tradeoff",),
    ("tasks",),
    ("session",),
    ("view.live", "figures", "cells"),
    ("batch", "serve", "ros"),
    ("lerobot",),
    ("cli",),
    ("", "__main__"),  # the package's lazy list of public names
    ("reproduce",),
    ("benchmarks",),
)
LEVELS = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}


def module_name(path: Path) -> str:
    parts = path.relative_to(TESTS.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for package in PACKAGES for path in sorted(package.rglob("*.py"))}
COMPILED = "planner.native.compiled"  # of C++

ROS = ("rclpy", "std_srvs", "builtin_interfaces", "rcl_interfaces", "geometry_msgs", "sensor_msgs", "std_msgs")
ROS += ("trajectory_msgs", "visualization_msgs")

DOORS = {
    "ompl": {
        "planner.roadmap.ompl_planners",
        "benchmarks.others.ompl",
    },
    "fcl": {"planner.collision.fcl"},
    "coal": {"planner.robot.files.urdf_geometry", "planner.collision.coal", "benchmarks.clouds"},
    "meshcat": {"planner.view.canvas"},
    "umsgpack": {"planner.view.canvas"},
    "viser": {"planner.view.live"},
    "websockets": {"planner.serve.server", "planner.serve.client", "planner.view.live"},
    "lerobot": {"planner.lerobot.steps"},
    "matplotlib": {name for name in MODULES if name.startswith("planner.figures")} | {"reproduce.figures"},
    "ctypes": {"planner.base.captured_output"},
    "yaml": {"planner.base.yamlfile"},
    **{library: {name for name in MODULES if name.startswith("planner.ros")} for library in ROS},
    "joblib": {"planner.batch.parallel"},
    "distributed": {"planner.batch.parallel"},
    "robot_descriptions": {"planner.robot.files.robot_files"},
    "trimesh": {"planner.robot.files.meshes", "benchmarks.clouds"},
    "mujoco": {"planner.robot.files.mjcf"},
    "xacro": {"planner.robot.files.packages"},
    "toppra": {"benchmarks.others.toppra_law"},
    "tyro": {name for name in MODULES if name.startswith("planner.cli") or name.endswith("commands")}
    | {"benchmarks.bench"},
}


def room(module: str) -> str:
    """The folder of a module; the live page stands above all that it shows."""
    package, *inside = module.split(".")
    if inside[:2] == ["view", "live"]:
        return "view.live"
    return package if package != "planner" else inside[0] if inside else ""


def level(module: str) -> int:
    return LEVELS[room(module)]


def imported(path: Path, at_module_level: bool = False) -> set[str]:
    """Modules that a file imports; names imported from a package count as its submodules where they are modules."""
    tree = ast.parse(path.read_text())
    nodes = tree.body if at_module_level else ast.walk(tree)
    names: set[str] = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                names.add(whole if whole in MODULES else node.module)
    return names


@pytest.mark.parametrize("module", MODULES)
def test_imports_point_downwards(module: str) -> None:
    for other in imported(MODULES[module]):
        if other.split(".")[0] not in ("planner", "reproduce", "benchmarks") or module == "planner":
            continue
        assert other in MODULES or other == COMPILED, f"{module} imports {other}, which is not there"
        below = room(other) == room(module) or level(other) < level(module)
        assert below, f"{module} (floor {level(module)}) imports {other} (floor {level(other)})"
        if room(module) == "gabf":
            assert room(other) in ("gabf", "base") or other == COMPILED, f"{module} has heard of {other}"
        if room(other) == "gabf" and room(module) != "gabf":
            assert level(module) >= LEVELS["search"], f"{module} is below the maths and imports {other}"


@pytest.mark.parametrize("module", MODULES)
def test_foreign_libraries_have_one_door(module: str) -> None:
    for name in imported(MODULES[module]):
        library = name.split(".")[0]
        assert module in DOORS.get(library, {module}), f"{module} imports {library}; its door is {DOORS[library]}"


def test_no_cycle_of_imports_wherever_they_stand() -> None:
    graph = {name: {o for o in imported(path) if o in MODULES} for name, path in MODULES.items() if name != "planner"}
    done: set[str] = set()

    def visit(name: str, trail: tuple[str, ...]) -> None:
        assert name not in trail, " -> ".join((*trail[trail.index(name) :], name))
        if name not in done:
            for other in sorted(graph[name] - {name, "planner"}):
                visit(other, (*trail, name))
            done.add(name)

    for name in graph:
        visit(name, ())


def test_the_mathematics_load_no_robot() -> None:
    code = "import planner.gabf, sys; print(' '.join({name.split('.')[0] for name in sys.modules}))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"pinocchio", "ompl", "fcl", "coal", "meshcat"} & set(loaded)
