"""``benchmarks attack``: planted false claims are found, its judges are right, the worst that was found is mended."""

import json
import sys
from dataclasses import replace
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from benchmarks.attack import misses
from benchmarks.attack.cases import KINDS, random_case
from benchmarks.attack.certificates import run as certificates
from benchmarks.attack.claims import attack_claims
from benchmarks.attack.proofs import compare_proofs
from benchmarks.attack.run import attack
from benchmarks.attack.segments import Proven, Sweep, attack_segments, judge_sweep
from benchmarks.attack.thin_obstacles import thin_case
from benchmarks.attack.true_distance import true_distance
from benchmarks.problems import find_problems
from benchmarks.results import read_rows
from planner.base.progress import QUIET
from planner.collision import BACKENDS, make_checker
from planner.collision.bounds import ClearanceBound
from planner.collision.coal import CoalChecker
from planner.collision.containment import Containment
from planner.native.compiled import NativeWorld
from planner.problem.request import PlanRequest
from planner.robot.clouds import Points
from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Body, Mesh
from tests.batch.posts import write_problem
from tests.coal_judge import coal_distance, coal_geometry
from tests.random_shapes import random_pose, random_shape
from tests.worlds import load

PAIRS = list(combinations_with_replacement(KINDS, 2))


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def too_short(monkeypatch: pytest.MonkeyPatch) -> None:
    """A prover that believes that points move less than they do."""
    honest = NativeWorld.bounds
    monkeypatch.setattr(NativeWorld, "bounds", lambda self, reach, *asked: honest(self, 0.3 * reach, *asked))


def test_a_planted_false_proof_ends_the_command_with_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.attack.run.PAIRS", (("box", "sphere"),))
    monkeypatch.setattr("benchmarks.attack.run.SEEN_PAIRS", (("box", "points"),))
    asked = {"parts": ("segments",), "segments": 24, "robots": ("planar_2r",), "libraries": ("fcl",)}
    assert attack(tmp_path / "honest", **asked) == 0
    too_short(monkeypatch)
    assert attack(tmp_path / "planted", **asked) == 4
    rows = read_rows(tmp_path / "planted" / "attack.csv", "python -m benchmarks attack")
    worst = max(rows, key=lambda row: row.clearance_m or 0.0)
    assert (worst.clearance_m or 0.0) > 1e-4
    report = (tmp_path / "planted" / "attack.md").read_text()
    assert f"- fcl segments, {worst.first} {worst.second}: " in report
    assert json.loads(worst.found)["robot"] == "planar_2r"
    assert attack(tmp_path / "planted", **asked) == 4  # of kept rows too


def test_planted_false_claims_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        honest = ClearanceBound.coarse
        patch.setattr(ClearanceBound, "coarse", lambda self, *placed: honest(self, *placed) + 1e-6)
        worst = attack_claims(("sphere", "box"), "coal", 48, rng(), QUIET)
        assert worst is not None
        assert worst.beyond > 5e-7
    with monkeypatch.context() as patch:
        patch.setattr(CoalChecker, "first_contact", lambda self, q: None)
        worst = attack_claims(("sphere", "sphere"), "coal", 96, rng(), QUIET)
        assert worst is not None
        assert worst.over["verdict"] > 1e-5
    too_short(monkeypatch)
    proven = attack_segments(("box", "sphere"), "fcl", 24, rng(), QUIET)
    assert proven is not None
    assert proven.false_free > 0
    assert proven.over > 1e-3
    proven = attack_segments(("box", "points"), "fcl", 60, rng(), QUIET)
    assert proven is not None
    assert proven.false_free > 0


@pytest.mark.parametrize("free", [False, True])
def test_a_point_inside_a_link_that_a_planted_prover_overlooks_is_found(
    free: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    crate = trimesh.creation.box([0.3, 0.2, 0.1])
    crate += trimesh.creation.box([0.1, 0.1, 0.1], pose([0.3, 0.0, 0.0]))  # planes see a convex mesh as solid
    link = Body("link", "link", 2, Mesh(crate.vertices, crate.faces), pose())
    arm = replace(load("planar_2r"), bodies=(link,))
    sweep = Sweep(arm, Points([[0.5, 0, 0]], 0.01), pose(), False, np.zeros(2), np.array([0.0, 0.1]))
    if free:
        monkeypatch.setattr(Containment, "pairs", lambda self, q: np.full(len(q), -1))
    proven = Proven()
    judge_sweep(sweep, "coal", proven)
    assert (proven.tried, proven.free, proven.false_free) == (1, int(free), int(free))


def test_edges_that_a_blind_prover_calls_free_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = load("planar_2r")
    case = thin_case(make_checker(robot, Scene("empty"), "coal"), "wall", 0.003, rng(2))

    class Blind:
        def __init__(self, checker: object) -> None: ...

        def prove(self, start: np.ndarray, delta: np.ndarray) -> object:
            return type("Proofs", (), {"free": np.ones(len(start), dtype=bool)})

    honest = list(misses.judge(robot, case, 5))
    assert any(one.touches["coal"] for one in honest)
    assert not any(one.missed(library) for one in honest for library in BACKENDS)
    monkeypatch.setattr(misses, "EdgeProver", Blind)
    blind = list(misses.judge(robot, case, 5))
    for library in BACKENDS:
        assert [one.missed(library) for one in blind] == [one.touches["coal"] for one in honest]


def test_a_false_certificate_that_is_accepted_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Waypoints are moved so that the path goes through the post, and the checker accepts that."""

    def through(case: Any, _: np.random.Generator) -> tuple[Any, Any, str]:
        ends = case.data["path"][[0, -1]]
        return {**case.data, "path": np.linspace(ends[0], ends[1], len(case.data["path"]))}, case.meta, "a planted one"

    monkeypatch.setattr(certificates, "CHUNK", 12)
    monkeypatch.setattr(certificates, "mutate", through)
    assert certificates.change(0, 0)["false_free"] == 0  # the honest checker refuses them
    monkeypatch.setattr("benchmarks.attack.certificates.mutations.verify_proof.check", lambda folder: "PROVEN")
    found = certificates.change(0, 0)
    assert found["false_free"] > 8
    assert "a planted one: too close" in found["found"]


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_the_true_distance_is_coals_and_sure(first: str, second: str) -> None:
    draw = rng(9)
    for k in range(20):
        a, b = (random_shape(draw, kind, ("normal", "thin", "large")[k % 3]) for kind in (first, second))
        p, q = random_pose(draw), random_pose(draw)
        gap = true_distance((a, p), (b, q))
        assert gap.high - gap.low < 1e-11
        assert gap.high == pytest.approx(max(0.0, coal_distance(coal_geometry(a), p, coal_geometry(b), q)), abs=1e-5)
        case = random_case((first, second), "distances", draw)
        gap = true_distance((case.first, case.place_first), (case.second, case.place_second))
        assert gap.low == pytest.approx(gap.high, abs=1e-8)


def test_motions_that_one_prover_alone_proves_are_looked_at(tmp_path: Path) -> None:
    """An HPP that proves everything, or nothing: a script in the place of its Python."""
    write_problem(tmp_path / "posts", "0001", (-1.0, 0.8), (1.0, -0.8))
    (problem,) = find_problems(tmp_path / "posts")
    plain, found = PlanRequest.from_options(robot="planar_2r", collision="coal"), []
    for proves in ("True", "False", "sys.exit(3)"):
        python = tmp_path / "python"
        python.write_text(
            f"#!{sys.executable}\nimport json, sys\nassert sys.argv[3] == 'hpp proofs'\n"
            "motions = json.load(open(sys.argv[4]))['motions']\n"
            f"found = {{name: [bool({proves}) for a, b in motions] for name in ('Dichotomy', 'Progressive')}}\n"
            "json.dump(found | {'Dichotomy_s': 1.0, 'Progressive_s': 2.0}, open(sys.argv[5], 'w'))\n"
        )
        python.chmod(0o755)
        found.append(compare_proofs(problem, plain, str(python), 60)[0])
    every, none, failed = found
    assert 0 < every["free"] == every["both"] < 60
    assert (every["only_ours"], every["only_theirs"], every["theirs_s"]) == (0, 60 - every["free"], 1.0)
    assert 0 < every["only_theirs_touching"] <= every["only_theirs"]
    assert (none["both"], none["only_ours"], none["false_free"], none["only_theirs"]) == (0, none["free"], 0, 0)
    assert "exit code 3" in failed["message"]
