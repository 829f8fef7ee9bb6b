"""Reports of progress: true totals, no long silence, the same plan with and without them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import planner
from planner.base.progress import QUIET, UNITS, Progress
from planner.base.resources import scenes_folder
from planner.collision.edge_prover import EdgeProver
from planner.planning.plan import plan
from planner.problem.request import TimingRequest

SCENES: list[dict[str, Any]] = [
    {"robot": "planar_2r", "scene": "cage", "nodes": 80},
    {"robot": "panda", "scene": "shelf", "nodes": 100, "beta": 0.0},
]
EXAMPLES = scenes_folder() / "examples"
MOST = 600  # motions proven between two reports: below 2 s, at the 3 ms that one takes of meshes full of dents


class Heard:
    """The reports of one plan, and how many motions are proven at most between two of them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.reports: list[tuple[str, int, int]] = []
        self.silent, self.longest = 0, (0, "")
        prove = EdgeProver._prove_batch

        def counted(prover: EdgeProver, coefficients: np.ndarray, resolution: float) -> Any:
            self.silent += len(coefficients)
            return prove(prover, coefficients, resolution)

        monkeypatch.setattr(EdgeProver, "_prove_batch", counted)

    def __call__(self, stage: str, done: int, total: int) -> None:
        self.reports.append((stage, done, total))
        self.longest, self.silent = max(self.longest, (self.silent, stage)), 0

    def passes(self, stage: str) -> list[list[tuple[int, int]]]:
        """(done, total) of every time that a stage was gone through: one begins where less is done than before."""
        found: list[list[tuple[int, int]]] = []
        for _, done, total in (report for report in self.reports if report[0] == stage):
            if not found or done < found[-1][-1][0]:
                found.append([])
            found[-1].append((done, total))
        return found


@pytest.mark.parametrize("options", SCENES, ids=lambda options: options["scene"])
def test_totals_are_true_and_no_stage_is_silent(options: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    heard = Heard(monkeypatch)
    made = plan(timing=TimingRequest(), progress=Progress(heard), **options)
    stages = {stage for stage, _, _ in heard.reports}
    assert {"setup", "roadmap", "links", "clearance", "improve", "second look"} <= stages <= UNITS.keys()
    for stage in stages:
        for gone in heard.passes(stage):
            done, totals = zip(*gone, strict=True)
            assert list(done) == sorted(done), stage
            assert done[-1] == totals[-1] > 0, stage
            assert max(done) <= max(totals), stage
    assert all(
        gone[0][0] == 0 for stage in ("setup", "clearance", "improve", "second look") for gone in heard.passes(stage)
    )
    assert heard.longest[0] <= MOST, heard.longest
    if options["scene"] == "cage":
        quiet = plan(timing=TimingRequest(), progress=QUIET, **options)
        assert (quiet.roadmap.sha256, quiet.path.tolist()) == (made.roadmap.sha256, made.path.tolist())


WORK: dict[str, tuple[Callable[[Progress], Any], set[str]]] = {
    "sweep": (
        lambda progress: planner.sweep("planar_2r", "cage", nodes=80, progress=progress),
        {"setup", "roadmap", "links", "improve", "second look", "beta", "timing"},
    ),
    "follow": (
        lambda progress: planner.follow(EXAMPLES / "seam.yaml", robot="panda", scene="table", progress=progress),
        {"setup", "ladder", "proofs"},
    ),
    "task": (
        lambda progress: planner.task(EXAMPLES / "tidy.yaml", nodes=100, timing=None, progress=progress),
        {"setup", "grasps", "proofs", "roadmap", "links", "modes"},
    ),
}


@pytest.mark.parametrize(("work", "stages"), WORK.values(), ids=WORK)
def test_other_work_reports_too(
    work: Callable[[Progress], Any], stages: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    heard = Heard(monkeypatch)
    work(Progress(heard))
    shown = {stage for stage, _, _ in heard.reports}
    assert stages <= shown <= UNITS.keys()
    for stage in shown:
        assert all(gone[-1][0] <= (gone[-1][1] or np.inf) for gone in heard.passes(stage)), stage
    assert heard.longest[0] <= MOST, heard.longest
