"""``planner sweep --seeds``: rows against single sweeps, the same from any number of jobs, resuming."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from planner.base.progress import Progress
from planner.batch.sweep_seeds import Row, sweep_seeds
from planner.problem.request import SERIAL, SweepRequest, WorkersRequest
from planner.tradeoff.sweep import sweep
from tests.command_line import Run, assert_refused
from tests.documents import ROOT

REQUEST = SweepRequest("planar_2r", "empty", nodes=40, collision="coal", effort=0)


def timeless(rows: tuple[Row, ...]) -> list[Row]:
    return [replace(row, seconds=0.0) for row in rows]


def test_rows_are_those_of_single_sweeps_for_any_number_of_jobs(tmp_path: Path) -> None:
    one, two = (sweep_seeds(REQUEST, (1, 2), tmp_path / str(w.jobs), workers=w) for w in (SERIAL, WorkersRequest(2)))
    assert timeless(one.rows) == timeless(two.rows)
    single = sweep(replace(REQUEST, seed=2))
    row = one.rows[1]
    assert (row.roadmap_sha256, row.intervals) == (single.roadmap.sha256, len(single.intervals))
    assert row.manipulability_cost == single.intervals[0].manipulability_cost
    assert row.distance_cost == single.intervals[-1].distance_cost
    for name in ("sweep.json", "sweep.html", "roadmap.npz"):
        assert (tmp_path / "2" / "seed-2" / name).is_file()


def test_an_interrupted_run_goes_on(tmp_path: Path) -> None:
    done: list[int] = []
    progress = Progress(lambda stage, k, of: done.append(k), lambda: max(done, default=0) >= 1)
    first = sweep_seeds(REQUEST, (1, 2), tmp_path, progress=progress)
    assert (len(first.rows), first.complete) == (1, False)
    second = sweep_seeds(REQUEST, (1, 2), tmp_path)
    assert second.complete
    assert second.rows[0] == first.rows[0]
    (tmp_path / "seed-1" / "sweep.json").unlink()
    assert sweep_seeds(REQUEST, (1, 2), tmp_path).rows[0].seconds != first.rows[0].seconds


def test_a_row_is_of_the_sweep_in_its_folder(tmp_path: Path) -> None:
    """Other options take the folder; asked for again, the first ones do not find their row beside it."""

    def written() -> dict[str, Any]:
        return json.loads((tmp_path / "seed-1" / "sweep.json").read_text())

    first = sweep_seeds(REQUEST, (1,), tmp_path).rows[0]
    sweep_seeds(replace(REQUEST, charge="nodes"), (1,), tmp_path)
    again = sweep_seeds(REQUEST, (1,), tmp_path).rows[0]
    assert again.manipulability_cost == first.manipulability_cost == written()["intervals"][0]["manipulability_cost"]
    assert len((tmp_path / "seeds.csv").read_text().splitlines()) == 2
    sweep_seeds(REQUEST, (1,), tmp_path, front=True)
    assert written()["front"]["complete"]


def test_a_limit_in_the_urdf_that_a_robot_file_names_is_part_of_what_is_asked(tmp_path: Path) -> None:
    own = ROOT / "robots" / "planar_2r"
    shutil.copytree(own, tmp_path / "arm")
    request = replace(REQUEST, robot=str(tmp_path / "arm"), start="q:0.1,0.4", goal="q:0.9,1.2")
    first = sweep_seeds(request, (1,), tmp_path / "out").rows
    assert sweep_seeds(request, (1,), tmp_path / "out").rows == first
    urdf = tmp_path / "arm" / "planar_2r.urdf"
    text = urdf.read_text()
    urdf.write_text(re.sub(r'upper="[^"]*"', 'upper="1.9"', text, count=1))
    assert urdf.read_text() != text
    again = sweep_seeds(request, (1,), tmp_path / "out").rows
    assert again[0].asked != first[0].asked
    assert again[0].roadmap_sha256 != first[0].roadmap_sha256


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (("--jobs", "2"), "give --seeds too"),
        (("--seeds", "1", "--seed", "3"), "leave --resume and --seed out"),
        (("--seeds", "1", "1"), "each only once"),
        (("--seeds", "1", "--backend", "dask"), "--scheduler"),
    ],
)
def test_wrong_options_are_one_sentence(options: tuple[str, ...], text: str, tmp_path: Path, run: Run) -> None:
    out = tmp_path / "out"
    assert_refused(run("sweep", "--robot", "planar_2r", "--scene", "empty", *options, "--out", str(out)), 2, text, out)
