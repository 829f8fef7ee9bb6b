"""``benchmarks certificate``: what certificates cost, and whether a false one is ever accepted."""

from __future__ import annotations

import json
import statistics
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.certificate.folders import AROUND, folder_of
from benchmarks.certificate.judge import beyond_limits, closest, least_w
from benchmarks.certificate.mutations import Case, Data, climbed, largest, mutated
from planner.base.errors import OptionError
from planner.base.files import make_folder, write_whole
from planner.base.progress import QUIET, Progress
from planner.base.tables import markdown_table
from planner.certificate import PROOF_NAME
from planner.certificate import verify as verified
from planner.certificate.geometry import geometry_of
from planner.certificate.verification import require_same_world
from planner.certificate.verify_proof import Refused
from planner.collision import make_checker
from planner.collision.world import World
from planner.models.poses import pose
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.models.shapes import Box, Obstacle
from planner.planning.plan import plan
from planner.planning.result import Plan, save_plan_without_page
from planner.problem.request import PlanRequest, TimingRequest, require_seed
from planner.trajectory.timing import time_path

MARGIN = 0.005  # m, of the path whose certificate is changed: what is nearer is a counterexample
FLOOR = 0.09  # m^2, of the path whose least w is 0.097
_CHUNK = 50  # certificates, of which one is the largest change in its direction that is accepted, and one a climb
_MOTIONS = 0.1  # the share of motions, which take longer to judge
_SAMPLES = 3  # configurations of each piece that an accepted certificate is judged by


@dataclass(frozen=True)
class Row:
    """What one plan's certificate cost, seconds of computing and bytes; ``verdict`` is "proven" or why it is not."""

    robot: str
    scene: str
    plan_s: float
    certify_s: float
    check_s: float
    size: int
    witnesses: int
    verdict: str


@dataclass(frozen=True)
class Attack:
    """How many certificates were changed, and accepted, by kind of change; what is false of those accepted."""

    counts: dict[str, tuple[int, int]]
    false: tuple[str, ...]

    @property
    def changed(self) -> int:
        """How many were changed."""
        return sum(changed for changed, _ in self.counts.values())


@dataclass(frozen=True)
class CertificateBench:
    """The plans' certificates, and how many of the changed ones were accepted, and were false all the same."""

    rows: tuple[Row, ...]
    seed: int
    asked: int
    attack: Attack

    @property
    def complete(self) -> bool:
        """Whether all changes were tried."""
        return self.attack.changed >= self.asked

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
    result = CertificateBench(tuple(rows), seed, changes, _attacked(changes, seed, folder, progress))
    write_whole(folder / "certificate.md", result.report.encode())
    return result


def _measured(request: PlanRequest) -> list[Row]:
    """The row of one plan; none where there is no path."""
    began = time.process_time()
    found = plan(request, timing=TimingRequest())
    plan_s = time.process_time() - began
    if not found.solved:
        return []
    with tempfile.TemporaryDirectory() as place:
        began = time.process_time()
        made = _saved(found, Path(place))
        certify_s = time.process_time() - began
        began = time.process_time()
        try:
            verdict = verified(Path(place), found.checker.world).partition(":")[0].lower()
        except Refused as why:
            verdict = str(why)
        check_s, size = time.process_time() - began, (Path(place) / PROOF_NAME).stat().st_size
    return [Row(found.robot.name, found.scene.name, plan_s, certify_s, check_s, size, made, verdict)]


def _saved(found: Plan, folder: Path) -> int:
    """Write the plan with its certificate; the number of witnesses."""
    save_plan_without_page(found, folder, certificate=True)
    return len(Case.of(folder).data["piece"])


def _attacked(changes: int, seed: int, folder: Path, progress: Progress) -> Attack:
    """Certificates changed in chunks, each with a line in the folder: those that are there are not tried again."""
    file, chunks = folder / "changes.jsonl", -(-changes // _CHUNK)
    lines = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    done = {line["chunk"]: line for line in lines if line["seed"] == seed}
    with tempfile.TemporaryDirectory() as place:
        cases = None
        for chunk in range(chunks):
            progress("changed certificates", min(chunk * _CHUNK, changes), changes)
            if progress.stopped:
                break
            if chunk not in done:
                cases = cases or _cases(Path(place), seed)
                done[chunk] = {"seed": seed, "chunk": chunk, **_tried(cases, np.random.default_rng([seed, chunk]))}
                with file.open("a") as stream:
                    stream.write(json.dumps(done[chunk]) + "\n")
    counts, false = dict[str, list[int]](), list[str]()
    for chunk in sorted(done.keys() & set(range(chunks))):
        for kind, (tried, accepted) in done[chunk]["counts"].items():
            before = counts.setdefault(kind, [0, 0])
            counts[kind] = [before[0] + tried, before[1] + accepted]
        false += [f"{what}, chunk {chunk}" for what in done[chunk]["false"]]
    return Attack({kind: (a, b) for kind, (a, b) in sorted(counts.items())}, tuple(false))


def _cases(folder: Path, seed: int) -> list[tuple[Case, World, float]]:
    """A path and a motion of few pairs, checked in milliseconds; with the margin (m) that they do not keep."""
    scene = Scene("post", (Obstacle("post", Box((0.1, 0.02, 0.2)), pose([0.75, 0.0, 0.0])),))
    checker, made = make_checker(Robot.load("planar_2r"), scene, margin=MARGIN), []
    for name, motion in (("path", None), ("motion", time_path(AROUND, checker, law="shortcuts"))):
        case = Case.of(folder_of(folder / name, checker, AROUND, motion, FLOOR)[0])
        made.append((case, checker.world, closest(case.data, 200, np.random.default_rng(seed), 1.0)))
    return made


def _tried(cases: list[tuple[Case, World, float]], rng: np.random.Generator) -> dict[str, Any]:
    """Counts of what was changed and of what was accepted, by kind, and what is false of that."""
    counts, false = dict[str, list[int]](), list[str]()
    for k in range(_CHUNK):
        case, world, near = cases[int(rng.random() < _MOTIONS)]
        if k == 0:
            data, kind = largest(case, rng) or (None, "")
            kind, words = "the largest change that is accepted", case.words
        elif k == 1:
            data, words = climbed(case, rng, near + 10.0 ** rng.uniform(-9, -4))
            data, kind = data if case.accepts(data, words) else None, "witnesses climbed to more than there is"
            false += [kind] if data is not None else []
        else:
            data, words, kind = mutated(case, rng)
            data = data if case.accepts(data, words, follow := bool(rng.random() < 0.5)) else None
            if data is not None and not follow and not _same(data, case.data, ("path", "clock", "knots", "limits")):
                false.append(f"{kind}: not what is in the folder")
        counts[kind] = [a + b for a, b in zip(counts.get(kind, [0, 0]), (1, int(data is not None)), strict=True)]
        if data is not None:
            false += [f"{kind}: {what}" for what in _wrong(case, data, words, world, rng)]
    return {"counts": counts, "false": false}


def _wrong(case: Case, data: Data, words: dict[str, Any], world: World, rng: np.random.Generator) -> list[str]:
    """What is not true of a certificate that was accepted; and whether it passes as one of another world's."""
    found = ["too close"] if closest(data, _SAMPLES, rng, MARGIN) < MARGIN - 1e-7 else []
    found += ["below the floor"] if least_w(data, words, _SAMPLES) < data["floor"] - 1e-9 else []
    found += ["beyond limits"] if beyond_limits(data) > 2e-6 else []
    try:
        require_same_world(case.folder / PROOF_NAME, world)
    except Refused:
        return found
    same = words == case.words and _same(data, case.data, tuple(geometry_of(world)))
    return found + ([] if same else ["of another world"])


def _same(one: Data, two: Data, names: tuple[str, ...]) -> bool:
    return all(np.array_equal(one[name], two[name]) for name in names)


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
    attack = result.attack
    accepted = sum(accepted for _, accepted in attack.counts.values())
    false = f"{accepted} were accepted, {len(attack.false)} of them false"
    counts = f"Of {attack.changed} certificates that were changed {false}. Seed {result.seed}."
    kinds = markdown_table(["changed", "certificates", "accepted"], [[kind, *n] for kind, n in attack.counts.items()])
    wrong = [f"- {what}" for what in attack.false]
    ending = [] if result.complete else ["", "Interrupted: the changes that were not tried are missing above."]
    return "\n".join([*markdown_table(heads, lines), *summary, "", counts, "", *kinds, *wrong, *ending]) + "\n"
