"""``benchmarks certificate``: what certificates cost, and whether a false one is ever accepted."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.certificate.judge import closest
from benchmarks.certificate.mutations import Case, largest, mutated
from planner.base.errors import OptionError
from planner.base.files import make_folder, write_whole
from planner.base.progress import QUIET, Progress
from planner.base.tables import markdown_table
from planner.certificate import PROOF_NAME
from planner.certificate import verify as verified
from planner.certificate.verify_proof import Refused
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.planning.plan import plan
from planner.planning.result import Plan, save_plan_without_page
from planner.problem.request import PlanRequest, TimingRequest, require_seed

MARGIN = 0.005  # m, of the plan whose certificate is changed: what is nearer is a counterexample
_SAMPLES = 3  # configurations of each piece that an accepted certificate is judged by
_CLIMB = 20  # one in so many changes is the largest one in its direction that is accepted


@dataclass(frozen=True)
class Row:
    """What one plan's certificate cost, seconds and bytes; ``verdict`` is "proven" or why it is not."""

    robot: str
    scene: str
    plan_s: float
    certify_s: float
    check_s: float
    size: int
    witnesses: int
    verdict: str


@dataclass(frozen=True)
class CertificateBench:
    """The plans' certificates, and how many of the changed ones were accepted, and were false all the same."""

    rows: tuple[Row, ...]
    seed: int
    changed: int
    accepted: int
    false: tuple[str, ...]
    complete: bool

    @property
    def report(self) -> str:
        """The table and the counts, as Markdown."""
        return _to_markdown(self)


def bench_certificate(
    folder: Path,
    changes: int = 10_000,
    robots: Sequence[str] = ("iiwa14", "panda", "ur5"),
    scenes: Sequence[str] = ("shelf", "table"),
    seed: int = 0,
    progress: Progress = QUIET,
) -> CertificateBench:
    """Certify a plan of every robot in every scene, and change one certificate ``changes`` times; ``certificate.md``.

    Raises OptionError for numbers out of range, RobotError and SceneError for names that are not known.
    """
    require_seed(seed)
    if changes < 1:
        raise OptionError("give at least 1 change.")
    for robot in robots:
        Robot.load(robot)
    for scene in scenes:
        Scene.load(scene)
    make_folder(folder)
    rows, cases = list[Row](), [(robot, scene) for robot in robots for scene in scenes]
    for k, (robot, scene) in enumerate(cases):
        progress("certificates", k, len(cases))
        if not progress.stopped:
            rows += _measured(PlanRequest(robot=robot, scene=scene, seed=seed))
    tried, accepted, false = _attacked(changes, seed, progress)
    result = CertificateBench(tuple(rows), seed, tried, accepted, tuple(false), tried >= changes)
    write_whole(folder / "certificate.md", result.report.encode())
    return result


def _measured(request: PlanRequest) -> list[Row]:
    """The row of one plan; none where there is no path."""
    began = time.perf_counter()
    found = plan(request, timing=TimingRequest())
    plan_s = time.perf_counter() - began
    if not found.solved:
        return []
    with tempfile.TemporaryDirectory() as place:
        began = time.perf_counter()
        made = _saved(found, Path(place))
        certify_s = time.perf_counter() - began
        began = time.perf_counter()
        try:
            verdict = verified(Path(place), found.checker.world).partition(":")[0].lower()
        except Refused as why:
            verdict = str(why)
        check_s, size = time.perf_counter() - began, (Path(place) / PROOF_NAME).stat().st_size
    return [Row(found.robot.name, found.scene.name, plan_s, certify_s, check_s, size, made, verdict)]


def _saved(found: Plan, folder: Path) -> int:
    """Write the plan with its certificate; the number of witnesses."""
    save_plan_without_page(found, folder, certificate=True)
    return len(Case.of(folder).data["piece"])


def _attacked(changes: int, seed: int, progress: Progress) -> tuple[int, int, list[str]]:
    """How many certificates were changed, how many of them accepted, and what is false of these."""
    rng, accepted, false = np.random.default_rng(seed), 0, list[str]()
    request = PlanRequest(robot="planar_2r", scene="shelf", margin=MARGIN, path_only=True, seed=seed)
    found = plan(request)
    with tempfile.TemporaryDirectory() as place:
        _saved(found, Path(place))
        case = Case.of(Path(place))
        for k in range(changes):
            if progress.stopped:
                return k, accepted, false
            progress("changed certificates", k, changes)
            if k % _CLIMB == 0:
                data, kind = largest(case, rng) or (None, "")
            else:
                data, words, kind = mutated(case, rng)
                data = data if case.accepts(data, words, follow=bool(rng.random() < 0.5)) else None
            if data is not None:
                accepted += 1
                if closest(data, _SAMPLES, rng, MARGIN) < MARGIN - 1e-7:
                    false.append(f"{kind} ({k})")
    return changes, accepted, false


def _to_markdown(result: CertificateBench) -> str:
    lines = [
        [
            row.robot, row.scene, f"{row.plan_s:.2f}", f"{row.certify_s:.2f}", f"{row.check_s:.2f}",
            f"{row.size / 1e3:.0f}", row.witnesses, row.verdict,
        ]
        for row in result.rows
    ]  # fmt: skip
    heads = ["robot", "scene", "plan, s", "saved with certificate, s", "check, s", "kB", "witnesses", "verdict"]
    summary = []
    if result.rows:
        check = statistics.median(row.check_s for row in result.rows)
        share = statistics.median(row.certify_s / row.plan_s for row in result.rows)
        summary = ["", f"In the median a check takes {check:.2f} s, and saving adds {share:.0%} to a plan."]
    false = f"{result.accepted} were accepted, {len(result.false)} of them false"
    counts = f"Of {result.changed} certificates that were changed {false}. Seed {result.seed}."
    wrong = [f"- {what}" for what in result.false]
    ending = [] if result.complete else ["", "Interrupted: the changes that were not tried are missing above."]
    return "\n".join([*markdown_table(heads, lines), *summary, "", counts, *wrong, *ending]) + "\n"
