"""The house: imports point downwards, each foreign library has one door, and nothing heavy loads too early."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "planner"

# level of a module or of all modules below a folder; the longest match counts
LEVELS = {
    "planner.errors": 0,
    "planner.outcome": 0,
    "planner.arrays": 0,
    "planner.hashing": 0,
    "planner.files": 0,
    "planner.interrupt": 0,
    "planner.targets": 0,
    "planner.request": 0,
    "planner.resources": 0,
    "planner.yamlfile": 1,
    "planner.poses": 1,
    "planner.shapes": 1,
    "planner.meshes": 1,
    "planner.urdf": 1,
    "planner.robot": 1,
    "planner.scene": 1,
    "planner.moveit": 1,
    "planner.kinematics": 2,
    "planner.collision": 2,
    "planner.resolve": 2,
    "planner.roadmap": 3,
    "planner.gabf": 3.5,  # beside the roadmap: it sees level 0 only, and only level 4 and up see it
    "planner.costs": 4,
    "planner.paths": 3,
    "planner.routes": 4,
    "planner.query": 3,
    "planner.tradeoff": 5,
    "planner.learning": 5,
    "planner.floor": 4,
    "planner.plan": 4,
    "planner.results": 5,
    "planner.view": 6,
    "planner.experiments": 7,
    "planner.benchmark": 7,
    "planner.cli": 7,
    "planner.__main__": 7,
    "planner": 7,  # the package's own lazy list of public names
}


def module_name(path: Path) -> str:
    parts = ("planner", *path.relative_to(PACKAGE).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}

DOORS = {
    "ompl": {"planner.roadmap.tree_planners", "planner.benchmark.ompl_prm"},
    "fcl": {"planner.collision.fcl_checker"},
    "coal": {"planner.meshes", "planner.collision.coal_checker"},
    "meshcat": {"planner.view.canvas"},
    "matplotlib": {name for name in MODULES if name.startswith("planner.view.") and name.endswith("figures")},
    "yaml": {"planner.yamlfile"},
    "tyro": {name for name in MODULES if name.startswith("planner.cli")},
}


def level(module: str) -> float:
    while module not in LEVELS:
        module = module.rpartition(".")[0]
    return LEVELS[module]


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
        if other.split(".")[0] != "planner" or module == "planner":
            continue
        assert other in MODULES, f"{module} imports {other}, which is not there"
        assert level(other) <= level(module), f"{module} (level {level(module)}) imports {other} above it"
        if module.startswith("planner.gabf"):
            assert other.startswith("planner.gabf") or level(other) == 0, f"{module} has heard of {other}"
        if other.startswith("planner.gabf") and not module.startswith("planner.gabf"):
            assert level(module) >= 4, f"{module} is below the maths and imports {other}"


@pytest.mark.parametrize("module", MODULES)
def test_foreign_libraries_have_one_door(module: str) -> None:
    for name in imported(MODULES[module]):
        library = name.split(".")[0]
        assert module in DOORS.get(library, {module}), f"{module} imports {library}; its door is {DOORS[library]}"


def test_no_cycle_of_module_level_imports() -> None:
    graph = {name: {o for o in imported(path, True) if o in MODULES} for name, path in MODULES.items()}
    done: set[str] = set()

    def visit(name: str, trail: tuple[str, ...]) -> None:
        assert name not in trail, " -> ".join((*trail[trail.index(name) :], name))
        if name not in done:
            for other in sorted(graph[name] - {name}):
                visit(other, (*trail, name))
            done.add(name)

    for name in graph:
        visit(name, ())


def test_the_rule_catches_an_import_that_points_up(tmp_path: Path) -> None:
    upward = tmp_path / "x.py"
    upward.write_text("from planner.plan import plan\n")
    assert {level(name) for name in imported(upward)} == {4}
    assert level("planner.robot") < 4


@pytest.mark.parametrize(
    ("statement", "forbidden"),
    [
        ("import planner.cli", {"pinocchio", "ompl", "fcl", "coal", "meshcat", "numpy", "pydantic", "scipy"}),
        ("import planner.gabf", {"pinocchio", "ompl", "fcl", "coal", "meshcat", "pydantic", "scipy"}),
        ("import planner; planner.PlanRequest", {"pinocchio", "ompl", "fcl", "numpy"}),
    ],
)
def test_nothing_heavy_loads_early(statement: str, forbidden: set[str]) -> None:
    code = f"{statement}\nimport sys; print(' '.join(sorted({{m.split('.')[0] for m in sys.modules}})))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not forbidden & set(loaded)
