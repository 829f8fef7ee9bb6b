"""What a batch is asked for: YAML, CSV and folders, refused by plan and option."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.base.errors import FileError
from planner.batch.run import ROW_NAME
from planner.batch.tasks import CSV_NAME, read_tasks
from planner.planning.result import JSON_NAME, PAGE_NAME, ROADMAP_NAME
from planner.trajectory.file import TRAJECTORY_NAME
from tests.batch.test_run import PLAIN

WRITTEN = (JSON_NAME, PAGE_NAME, ROADMAP_NAME, TRAJECTORY_NAME, ROW_NAME)  # into a plan's folder


def test_csv_and_paths_beside_the_file(tmp_path: Path) -> None:
    (tmp_path / "cell.yaml").write_text("obstacles: []\n")
    path = tmp_path / "batch.csv"
    path.write_text(
        'name,scene,goal,beta,min-manipulability,request\na,cell.yaml,"q:0.3,0.4",0.2,,\n,shelf,goal,,0.01,\n'
    )
    a, b = read_tasks(path, PLAIN)
    assert (a.name, a.request.scene, a.request.beta) == ("a", str(tmp_path / "cell.yaml"), 0.2)
    assert (b.name, b.request.scene, b.request.beta, b.request.min_manipulability) == ("0002", "shelf", 0.5, 0.01)
    before = a.asked
    (tmp_path / "cell.yaml").write_text("obstacles: []\nname: other\n")
    assert a.asked != before


def test_goals_and_what_is_kept_may_be_lists_as_in_scene_files(tmp_path: Path) -> None:
    path = tmp_path / "batch.yaml"
    path.write_text("plans: [{goal: [home, 'q:0,1'], keep: ['plane:0,0,1,0.1', 'plane:1,0,0,-1']}, {keep: [1]}]\n")
    with pytest.raises(FileError, match="plan '0002': option 'keep'"):
        read_tasks(path, PLAIN)
    path.write_text(path.read_text().replace(", {keep: [1]}", ""))
    (task,) = read_tasks(path, PLAIN)
    assert (task.request.goal, task.request.keep) == ("home;q:0,1", "plane:0,0,1,0.1;plane:1,0,0,-1")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("plans: []", "plans"),
        ("plan: [{}]", "plan"),
        ("plans: [{speed: 1}]", "plan '0001': option 'speed' not found"),
        ("plans: [{margn: 1}]", "option 'margn' not found .did you mean 'margin'"),
        ("plans: [{nodes: 20, nodes: 30}]", "key 'nodes' stands twice"),
        ("plans: [{beta: 2}]", "beta 2 is outside"),
        ("plans: [{name: a, nodes: many}]", "plan 'a': option 'nodes'"),
        ("plans: [{name: a}, {name: a}]", "two plans called 'a'"),
        ("plans: [{name: ../a}]", "cannot be the name of a folder"),
        ("plans: [{name: /a}]", "cannot be the name of a folder"),
        *(
            (f"plans: [{{name: a}}, {{name: {name}}}]", "is the name of a file that a batch writes")
            for name in (CSV_NAME, "a/Roadmap.npz/b", *(f"a/{name}" for name in WRITTEN))
        ),
    ],
)
def test_a_file_that_makes_no_sense_is_refused_by_plan_and_option(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "batch.yaml"
    path.write_text(text)
    with pytest.raises(FileError, match=message):
        read_tasks(path, PLAIN)


def test_a_column_that_stands_twice_is_refused(tmp_path: Path) -> None:
    (tmp_path / "batch.csv").write_text("\ufeffname,beta\na,0.1\n")  # as Excel begins a file
    assert [task.name for task in read_tasks(tmp_path / "batch.csv", PLAIN)] == ["a"]
    (tmp_path / "batch.csv").write_text("name,beta,beta\na,0.1,0.9\n")
    with pytest.raises(FileError, match="two columns called 'beta'"):
        read_tasks(tmp_path / "batch.csv", PLAIN)


def test_a_cell_without_end_is_refused(tmp_path: Path) -> None:
    (tmp_path / "batch.csv").write_text(f"name,scene\na,{'x' * 140_000}\n")
    with pytest.raises(FileError, match=r"batch\.csv is no CSV: field larger than field limit"):
        read_tasks(tmp_path / "batch.csv", PLAIN)
