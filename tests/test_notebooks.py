"""Every notebook runs and defines no algorithm."""

import ast
import importlib
import re
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import nbformat
import pytest

FOLDER = Path(__file__).resolve().parents[1] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))

each = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


@each
def test_its_code_runs(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In this process, which has loaded the planner: a kernel for each notebook takes twice as long."""
    monkeypatch.chdir(FOLDER)
    monkeypatch.setattr(plt, "show", lambda: plt.close("all"))
    namespace: dict[str, Any] = {}
    for cell in nbformat.read(path, as_version=4).cells:
        if cell.cell_type == "code":
            exec(re.sub(r"^%.*$", "", cell.source, flags=re.MULTILINE), namespace)
    plt.close("all")


@each
def test_uses_public_names_only(path: Path) -> None:
    """All of `planner` that a notebook names stands in the reference; the first tutorial imports the package alone."""
    cells = nbformat.read(path, as_version=4).cells
    code = "\n".join(line for c in cells if c.cell_type == "code" for line in c.source.splitlines() if line[:1] != "%")
    named, imports = set[tuple[str, str]](), list[str]()
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            imports += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            imports.append(node.module or "")
            named |= {(node.module or "", alias.name) for alias in node.names}
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name | ast.Attribute):
            named.add((ast.unparse(node.value), node.attr))
    documented = {name: set(importlib.import_module(name).__all__) for name in documented_modules()}
    assert {name for name in imports if name.split(".")[0] == "planner"} <= set(documented)
    hidden = [f"{of}.{name}" for of, name in named if of in documented and name not in documented[of]]
    assert not hidden, f"not in docs/reference: {hidden}"
    assert path.stem != "01_first_plan" or imports == ["planner"]


def documented_modules() -> list[str]:
    """The modules whose names docs/reference lists."""
    pages = "".join(page.read_text() for page in (FOLDER.parent / "docs/reference").glob("*.md"))
    modules = re.findall(r"currentmodule:: (\S+)", pages)
    assert "planner" in modules
    return modules


@each
def test_defines_no_algorithm(path: Path) -> None:
    for cell in nbformat.read(path, as_version=4).cells:
        if cell.cell_type == "code":
            source = "\n".join(line for line in cell.source.splitlines() if not line.startswith("%"))
            logic = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda, ast.While)
            found = [node for node in ast.walk(ast.parse(source)) if isinstance(node, logic)]
            assert not found, f"line {found[0].lineno} of a cell: algorithms live in planner"
