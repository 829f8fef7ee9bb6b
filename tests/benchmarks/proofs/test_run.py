"""``benchmarks proofs``: both provers get the same motions, what one alone proves is looked at."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest

from benchmarks.proofs.report import Row, aims, to_markdown
from benchmarks.proofs.run import bench_proofs, random_motions
from planner.base.errors import OptionError
from planner.collision import make_checker
from planner.collision.checker import is_free
from planner.models.scene import Scene
from planner.problem.request import PlanRequest
from tests.batch.posts import write_problem
from tests.worlds import load, make_post

PLAIN = PlanRequest(robot="planar_2r", collision="coal")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_problem(tmp_path / "posts", "0001", (-1.0, 0.8), (1.0, -0.8))
    return tmp_path / "posts"


def python_that(folder: Path, proves: str) -> str:
    """A Python of another environment with an HPP in it that ``proves`` motions."""
    file = folder / "python"
    file.write_text(
        f"#!{sys.executable}\nimport json, sys\nassert sys.argv[3] == 'hpp proofs'\n"
        "motions = json.load(open(sys.argv[4]))['motions']\n"
        f"found = {{name: [bool({proves}) for a, b in motions] for name in ('Dichotomy', 'Progressive')}}\n"
        "json.dump(found | {'Dichotomy_s': 1.0, 'Progressive_s': 2.0}, open(sys.argv[5], 'w'))\n"
    )
    file.chmod(0o755)
    return str(file)


def measured(folder: Path, proves: str, motions: int = 60) -> tuple[Row, Row]:
    python = python_that(folder.parent, proves)
    first, second = bench_proofs(folder, folder.parent / "out", PLAIN, python, motions).rows
    return first, second


def test_what_hpp_alone_proves_is_looked_at(folder: Path) -> None:
    """An HPP that proves all: whatever we do not prove it proves alone, and what the post is in the way of touches."""
    row, other = measured(folder, "True")
    assert (row.method, other.method, row.theirs_s, other.theirs_s) == ("Dichotomy", "Progressive", 1.0, 2.0)
    assert row.proven is not None
    assert row.only_theirs is not None
    assert row.only_theirs_touching is not None
    assert (row.motions, row.both, row.only_ours, row.only_ours_touching) == (60, row.proven, 0, 0)
    assert row.only_theirs == 60 - row.proven
    assert 0 < row.only_theirs_touching <= row.only_theirs
    assert row.message.startswith("motion proven by theirs alone: 'link")


def test_what_we_alone_prove_is_looked_at_and_known_rows_are_kept(folder: Path) -> None:
    row, _ = measured(folder, "False")
    assert row.proven is not None
    assert (row.both, row.only_ours, row.only_ours_touching, row.only_theirs) == (0, row.proven, 0, 0)
    assert 0 < row.proven < 60
    assert measured(folder, "True")[0] == row
    with pytest.raises(OptionError, match="0 motions are too few for 1 scenes"):
        measured(folder, "True", 0)


def test_a_scene_that_cannot_be_compared_is_a_row(folder: Path) -> None:
    row, _ = measured(folder, "sys.exit(3)")
    assert "exit code 3" in row.message
    assert row.proven is None
    assert "- posts/0001, Dichotomy: HPP in " in to_markdown([row])


def test_motions_begin_free_and_end_within_limits() -> None:
    checker = make_post()
    start, delta = random_motions(checker, 200, np.random.default_rng(0))
    assert start.shape == delta.shape == (200, 2)
    assert all(is_free(checker, q) for q in start)
    assert ((start + delta >= checker.robot.lower) & (start + delta <= checker.robot.upper)).all()
    assert np.linalg.norm(delta, axis=1).min() < 0.5 < np.linalg.norm(delta, axis=1).max()


def test_motions_do_not_begin_with_a_body_inside_another() -> None:
    """HPP looks at surfaces, of which none is crossed there; so these would be told as proofs that touch."""
    checker = make_checker(load("panda"), Scene.load("empty"), "coal")
    inside = np.array([[-2.53, -1.14, 0.87, -2.47, -0.73, 0.01, 2.39]])
    outside = np.mean([checker.robot.lower, checker.robot.upper], axis=0)[None]
    assert checker.first_touch(inside) is None
    rng = MagicMock()
    rng.uniform.side_effect = [inside, outside, outside, np.ones((1, 1))]
    start, _ = random_motions(checker, 1, rng)
    np.testing.assert_array_equal(start, outside)


def test_the_report_adds_up() -> None:
    def row(method: str, touching: int) -> Row:
        counts = dict(zip(("both", "only_ours", "only_ours_touching"), (5, 2, touching), strict=True))
        more = {"only_theirs": 1, "only_theirs_touching": 1, "ours_s": 0.01, "theirs_s": 0.1}
        return Row("a", method, 0, "panda", 10, "", "", proven=7, **counts, **more)  # type: ignore[arg-type]

    rows = [row("Dichotomy", 0), row("Dichotomy", 1), row("Progressive", 0)]
    report = to_markdown(rows)
    assert "| Dichotomy | 2 | 20 | 14 | 10 | 4 | 1 | 2 | 2 | 1 | 10 |" in report
    assert "| Progressive | 1 | 10 | 7 | 5 | 2 | 0 | 1 | 1 | 1 | 10 |" in report
    assert [(aim.confirmed, aim.of) for aim in aims(rows)] == [(2, 3)]


@pytest.mark.skipif("HPP_PYTHON" not in os.environ, reason="HPP_PYTHON names no Python of an environment with HPP")
def test_hpp_itself_agrees(folder: Path) -> None:
    rows = bench_proofs(folder, folder.parent / "out", PLAIN, os.environ["HPP_PYTHON"], 100).rows
    for row in rows:
        assert row.proven is not None, row.message
        assert row.both is not None
        assert 0 < row.both <= row.proven < 100
        assert row.both >= 0.95 * row.proven
        assert row.only_ours_touching == 0
