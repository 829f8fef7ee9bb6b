"""Problems found in folders."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.plan.run import plan
from planner.base.errors import FileError
from planner.batch.problems import find_problems
from tests.batch.posts import PLAIN, write_problem


def test_problems_are_found_in_folders_and_flat(problems: Path, tmp_path: Path) -> None:
    found = find_problems(problems)
    assert [(p.name, p.kind) for p in found] == [("far/0001", "far"), ("posts/0001", "posts")]
    assert len({p.content(PLAIN) for p in found}) == 2
    flat = find_problems(problems / "posts")
    assert [(p.name, p.kind) for p in flat] == [("posts/0001", "posts")]
    assert flat[0].content(PLAIN) == found[1].content(PLAIN)
    write_problem(tmp_path, "_a", (0, 0), (1, 1))
    (tmp_path / "scene_a.yaml").rename(tmp_path / "scene_a.scene")
    (tmp_path / "request_b.yml").write_text("")
    (tmp_path / "scene0001_sensed.yaml").write_text("")
    a, b = find_problems(tmp_path)
    assert (a.name, a.scene.name) == (f"{tmp_path.name}/_a", "scene_a.scene")
    assert (b.scene.name, b.scene.exists()) == ("scene_b.yaml", False)


def test_linked_folders_are_looked_into_and_links_back_are_not_followed(problems: Path, tmp_path: Path) -> None:
    (tmp_path / "linked").symlink_to(problems / "posts", target_is_directory=True)
    (tmp_path / "own").mkdir()
    write_problem(tmp_path / "own", "0002", (0, 0), (1, 1))
    (tmp_path / "own" / "back").symlink_to(tmp_path, target_is_directory=True)
    assert [p.name for p in find_problems(tmp_path)] == ["linked/0001", "own/0002"]


def test_a_problem_is_another_where_the_robot_is_another(tmp_path: Path) -> None:
    """Rows are kept by what is read: with another robot file, or another mesh, the plan is measured again."""
    write_problem(tmp_path, "0001", (0, 0), (1, 1))
    problem = find_problems(tmp_path)[0]
    assert problem.content(replace(PLAIN, robot="ur5")) != problem.content(replace(PLAIN, robot="panda"))
    before = problem.content(PLAIN)
    problem.scene.write_text(problem.scene.read_text() + "\n")
    assert problem.content(PLAIN) != before


def test_a_folder_without_problems_is_refused(tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(FileError, match="holds no problems"):
            plan(folder, PLAIN, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("second", ["{name}/request0001.yaml", "request0001.yml"])
def test_two_problems_of_one_name_are_refused(second: str, tmp_path: Path) -> None:
    """Both were planned into one folder, and the row of one stood for both."""
    write_problem(tmp_path, "0001", (0, 0), (1, 1))
    other = tmp_path / second.format(name=tmp_path.name)
    other.parent.mkdir(exist_ok=True)
    other.write_text((tmp_path / "request0001.yaml").read_text())
    with pytest.raises(FileError, match=f"would both be the plan '{tmp_path.name}/0001'"):
        find_problems(tmp_path)
