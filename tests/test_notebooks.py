"""Every notebook runs from a clean kernel and defines no algorithm; the copy in the repository has its outputs."""

import ast
import importlib
import itertools
import re
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = Path(__file__).resolve().parents[1] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))

each = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def outputs(path: Path) -> list[Any]:
    """What the kept copy's code cells show."""
    cells = nbformat.read(path, as_version=4).cells
    return [output for cell in cells if cell.cell_type == "code" for output in cell.outputs]


def texts(path: Path) -> list[str]:
    """Every line of text that the kept copy's cells show."""
    shown = [output.get("text", "") or output.get("data", {}).get("text/plain", "") for output in outputs(path)]
    return [line for text in shown for line in text.splitlines()]


def kinds(notebook: Any) -> list[list[str]]:
    """The sorts of output that each code cell shows; a text may come in one piece or in several."""
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    return [[kind for kind, _ in itertools.groupby(o.get("name", o.output_type) for o in c.outputs)] for c in cells]


@each
def test_runs_from_a_clean_kernel(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = []
    resources = {"metadata": {"path": str(FOLDER)}}
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources=resources).execute()
    assert kinds(notebook) == kinds(nbformat.read(path, as_version=4))


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
