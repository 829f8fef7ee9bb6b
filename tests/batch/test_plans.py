"""The plans that YAML and CSV files and folders of MoveIt's problems ask for."""

from pathlib import Path

import pytest

from planner.base.errors import FileError
from planner.batch.run import read_plans
from tests.batch.posts import PLAIN, write_problem


def written(folder: Path, text: str, name: str = "batch.yaml") -> Path:
    (folder / name).write_text(text)
    return folder / name


def test_problems_are_found_in_folders_and_flat(problems: Path, tmp_path: Path) -> None:
    assert [task.name for task in read_plans(problems, PLAIN)] == ["far/0001", "posts/0001"]
    assert [task.name for task in read_plans(problems / "posts", PLAIN)] == ["posts/0001"]
    (tmp_path / "linked").symlink_to(problems / "posts", target_is_directory=True)
    write_problem(tmp_path / "own", "_a", (0, 0), (1, 1))
    (tmp_path / "own" / "scene_a.yaml").rename(tmp_path / "own" / "scene_a.scene")
    (tmp_path / "own" / "request_b.yml").write_text("")
    linked, a, b = read_plans(tmp_path, PLAIN)
    assert (linked.name, a.name, b.name) == ("linked/0001", "own/_a", "own/_b")
    assert (a.request.what.scene, b.request.what.scene) == (str(tmp_path / "own" / "scene_a.scene"), "own/scene_b.yaml")
    assert a.request.what.motion_plan_request == tmp_path / "own" / "request_a.yaml"


def test_folders_without_problems_or_with_two_of_one_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="holds no problems"):
        read_plans(tmp_path, PLAIN)
    write_problem(tmp_path, "0001", (0, 0), (1, 1))
    (tmp_path / "request0001.yml").write_text("")
    with pytest.raises(FileError, match=f"two plans called '{tmp_path.name}/0001'"):
        read_plans(tmp_path, PLAIN)


REFUSED = [
    *("plans: []", "plan: [{}]", "plans: [{margn: 1}]", "plans: [{nodes: 20, nodes: 30}]", "plans: [{beta: 2}]"),
    *("plans: [{beta: yes}]", "plans: [{}, {constraint: [1]}]", "plans: [{name: a}, {name: a}]"),
    *(f"plans: [{{name: {name}}}]" for name in ("../a", "/a", "a/../..", "''", ".")),
]


@pytest.mark.parametrize("text", REFUSED)
def test_a_wrong_yaml_file_is_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(FileError):
        read_plans(written(tmp_path, text), PLAIN)


@pytest.mark.parametrize(
    "text", ["", "name,beta\n", "name,beta,beta\na,0.1,0.9\n", "name,goal\na,q:0,1\n", f"name\n{'x' * 140_000}\n"]
)
def test_a_table_whose_cells_have_no_column_is_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"batch\.csv must be a line of different option names and a line of as many"):
        read_plans(written(tmp_path, text, "batch.csv"), PLAIN)
