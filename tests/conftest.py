"""Fixtures of several rooms."""

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import jsonschema
import pytest

from benchmarks.__main__ import main as benchmarks_main
from planner import cli
from planner.collision.checker import CollisionChecker
from planner.planning.result import Plan
from planner.roadmap.roadmap import Roadmap
from reproduce.__main__ import main as reproduce_main
from tests.batch.posts import write_cell, write_problem
from tests.command_line import Run, assert_remedies_are_options
from tests.worlds import (
    checker_of,
    make_post,
    small_plan,
)


@pytest.fixture(scope="session", autouse=True)
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Tests have a cache folder of their own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def solved() -> Plan:
    """The paper's scenario on 150 nodes, solved."""
    return small_plan()


@pytest.fixture(scope="session")
def problems(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One that is solved, and one whose goal is out of limits."""
    folder = tmp_path_factory.mktemp("problems")
    write_problem(folder / "posts", "0001", (-1.0, 0.8), (1.0, -0.8))
    write_problem(folder / "far", "0001", (-1.0, 0.8), (1.0, -2.99))
    write_cell(folder / "cells")
    return folder


@pytest.fixture(scope="session")
def roadmap(solved: Plan) -> Roadmap:
    return solved.roadmap


@pytest.fixture(scope="session")
def paper() -> CollisionChecker:
    """iiwa14 in the paper's scene."""
    return checker_of("iiwa14", "paper")


@pytest.fixture
def urdf_file(tmp_path: Path) -> Callable[..., str]:
    """Writes the inside of a URDF to a file and returns its path."""

    def write(inside: str, name: str = "arm", version: str = "1.0") -> str:
        path = tmp_path / f"{name}.urdf"
        path.write_text(f'<robot name="{name}" version="{version}">{inside}</robot>')
        return str(path)

    return write


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run a command line in this process: (exit code, standard output, standard error)."""
    programs = {"planner": cli.main, "benchmarks": benchmarks_main, "reproduce": reproduce_main}

    def call(*arguments: str, program: str = "planner") -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", [program, *arguments])
        with pytest.raises(SystemExit) as stop:
            programs[program]()
        output = capsys.readouterr()
        if program == "planner":
            assert_remedies_are_options(arguments, output.err)
        return int(stop.value.code or 0), output.out, output.err

    return call


@pytest.fixture(scope="session")
def post() -> CollisionChecker:
    return make_post()


@pytest.fixture
def validator(request: pytest.FixtureRequest, run: Run) -> jsonschema.Draft202012Validator:
    """A validator of the schema that the command prints, made without the models."""
    code, out, _ = run("schema", request.param)
    assert code == 0
    schema = json.loads(out)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)
