"""``planner bench quality``: every method is a row, ratios are to RRTConnect's, and rows that are there are kept."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from planner.base.errors import OptionError
from planner.base.request import PlanRequest
from planner.collision import make_checker
from planner.collision.edge_prover import EdgeProver
from planner.paths.measure import path_contact
from planner.query.open import make_query
from planner.roadmap.motions import Motions
from planner.roadmap.ompl_planners import JointSpace, seed_everything
from planner.studies.bench_plan.rows import SOLVED
from planner.studies.bench_quality.ompl_paths import PLANNERS, OmplPaths
from planner.studies.bench_quality.report import Row, aims, to_markdown
from planner.studies.bench_quality.run import bench_quality
from tests.studies.bench_plan.test_run import write_problem

PLAIN = PlanRequest(robot="planar_2r", nodes=40, collision="coal")


def row(problem: str, method: str, settings: str = "", **more: float) -> Row:
    return Row(problem, method, settings, 0, "coal", 1.0, "", "", SOLVED, straight_rad=1.0, w_min=1.0, **more)  # type: ignore[arg-type]


def test_every_method_is_a_row_and_none_is_measured_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_problem(tmp_path / "posts", "0001", (-1.0, 0.8), (1.0, -0.8))
    folder, out = tmp_path / "posts", tmp_path / "out"
    found = bench_quality(folder, out, PLAIN, betas=(1.0,), efforts=(2,), seconds=0.3)
    assert found.complete
    assert [one.method for one in found.rows] == ["RRTConnect", "RRT*", "BIT*", "planner"]
    assert {one.outcome for one in found.rows} == {SOLVED}
    assert all(one.length_rad is not None and one.length_rad >= (one.straight_rad or 0.0) for one in found.rows)
    ours = found.rows[-1]
    assert ours.cost is not None
    assert ours.lower_bound is not None
    assert ours.lower_bound <= ours.cost
    monkeypatch.setattr("planner.studies.bench_quality.run._measure", lambda *_: [])
    again = bench_quality(folder, out, PLAIN, betas=(1.0,), efforts=(2,), seconds=0.3)
    assert again.rows == found.rows
    with pytest.raises(OptionError, match="at least one beta"):
        bench_quality(folder, out, PLAIN, betas=())


@pytest.mark.parametrize("name", PLANNERS)
def test_ompls_paths_join_the_ends_and_look_free(name: str) -> None:
    query = make_query(replace(PLAIN, scene="empty"))
    seed_everything(0)
    check = Motions(EdgeProver(query.checker)).looks_free(0.02)
    with OmplPaths(JointSpace.of(query.robot), check) as planners:
        path = planners.path(name, query.starts, query.goals, 0.3)
    assert path is not None
    assert (path[0] == query.starts[0]).all()
    assert (path[-1] == query.goals).all(axis=1).any()
    assert path_contact(make_checker(query.robot, query.scene, "coal"), path, 0.02) is None


def test_ratios_are_to_rrtconnect_on_the_same_problem() -> None:
    ours = "beta 1, effort 6, 40 nodes"
    rows = [
        row("a", "RRTConnect", length_rad=2.0, w_mean=1.0, corners=3, dips=False, cpu_s=1.0),
        row("b", "RRTConnect", length_rad=4.0, w_mean=1.0, corners=3, dips=False, cpu_s=1.0),
        row("a", "planner", ours, length_rad=1.8, w_mean=1.0, corners=1, dips=True, cpu_s=2.0),
        row("b", "planner", ours, length_rad=3.8, w_mean=1.0, corners=4, dips=True, cpu_s=2.0),
    ]
    line = next(line for line in to_markdown(rows).splitlines() if line.startswith("| planner"))
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells[:4] == [f"planner {ours}", "2", "2", "2.8"]
    assert cells[-4:] == ["0.925", "1", "1", "2"]
    short, turns, *_ = aims(rows)
    assert short.holds
    assert turns.holds
    assert not aims([*rows, replace(rows[2], corners=9), replace(rows[3], corners=9)])[1].holds
