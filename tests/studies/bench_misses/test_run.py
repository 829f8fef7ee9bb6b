"""``planner bench misses``: nothing that the proof certifies touches, OMPL's rule is OMPL's, and misses are told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ompl import base as ob

from planner.base.errors import OptionError, RobotError
from planner.base.progress import Progress
from planner.collision import make_checker
from planner.studies.bench_misses import run as bench
from planner.studies.bench_misses.report import Row, to_markdown
from planner.studies.bench_misses.resolution import states_by_ompls_rule
from planner.studies.bench_misses.run import bench_misses, judge, look_closely
from planner.studies.bench_misses.thin_obstacles import KINDS, thin_case
from planner.studies.table import read_rows
from planner.world.poses import pose
from planner.world.robot import Robot
from planner.world.scene import Scene
from planner.world.shapes import Box, Obstacle
from tests.worlds import load, random_q


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("misses")
    bench_misses(place, edges=8, robots=("planar_2r",), thicknesses=(1.0, 5.0))
    bench_misses(place, edges=5, robots=("ur5",), thicknesses=(2.0,))
    return place


def test_nothing_certified_touches(folder: Path) -> None:
    rows = read_rows(folder / "misses.csv", Row, "planner bench misses")
    assert len(rows) == 9
    for row in rows:
        assert row.fcl_missed == row.coal_missed == 0, row.found
        assert row.fcl_proven + row.touching + row.fcl_left_out == row.edges
        assert row.coal_proven + row.touching + row.coal_left_out == row.edges
    # the cases are worth their name: some touch, some do not, nearly all of those are certified, and OMPL's rule errs
    total = {
        name: sum(getattr(row, name) for row in rows) for name in ("edges", "touching", "fcl_proven", "ompl_missed")
    }
    assert 0.2 < total["touching"] / total["edges"] < 0.9
    assert total["fcl_proven"] > 0.85 * (total["edges"] - total["touching"])
    assert total["ompl_missed"] > 0


def test_the_same_seed_gives_the_same_rows(folder: Path, tmp_path: Path) -> None:
    again = bench_misses(tmp_path, edges=8, robots=("planar_2r",), thicknesses=(5.0,)).rows
    assert set(again) <= set(read_rows(folder / "misses.csv", Row, "planner bench misses"))
    one, two = (bench_misses(tmp_path, edges=2, robots=("planar_2r",), thicknesses=(1.0,), seed=s).rows for s in (0, 1))
    assert [row.looks for row in one] != [row.looks for row in two]


def test_a_stop_keeps_what_is_there(tmp_path: Path) -> None:
    found = bench_misses(
        tmp_path, edges=5, robots=("planar_2r",), thicknesses=(5.0,), progress=Progress(stop=lambda: True)
    )
    assert found.rows == ()
    assert not found.complete
    assert "Interrupted" in (tmp_path / "misses.md").read_text()


@pytest.mark.parametrize("kind", KINDS)
def test_cases_are_thin_and_their_ends_are_free(kind: str) -> None:
    robot = load("iiwa14")
    case = thin_case(make_checker(robot, Scene("empty"), "coal"), kind, 0.003, np.random.default_rng(4))
    for item in case.scene.obstacles:
        size = np.array(item.shape.size) if isinstance(item.shape, Box) else np.array([2 * item.shape.radius])  # type: ignore[union-attr]
        assert size.min() == pytest.approx(0.003)
    assert len(case.scene.obstacles) == {"wall": 1, "pole": 1, "window": 4}[kind]
    checker = make_checker(robot, case.scene, "fcl")
    assert checker.first_contact(np.vstack([case.start, case.start + case.delta])) is None
    for q in (case.start, case.start + case.delta):
        assert ((q >= robot.lower) & (q <= robot.upper)).all()


def _wall_between() -> tuple[Robot, Scene, np.ndarray, np.ndarray]:
    """A wall of 1 mm that planar_2r's stretched arm passes halfway between two states of OMPL's rule."""
    robot = load("planar_2r")
    start, delta = np.array([-0.08, 0.0]), np.array([0.16, 0.0])
    states = states_by_ompls_rule(robot, start, delta)
    assert len(states) == 3  # so 0 is looked at, and the wall stands beside it
    wall = Obstacle("wall", Box((0.02, 0.001, 0.5)), pose([0.895, 0.036, 0.0], rpy=[0, 0, 0.04]))
    return robot, Scene("wall", (wall,)), start, delta


def test_a_prover_that_looks_away_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """The suite would see a miss: with proofs that call everything free, every touching edge is one."""
    robot = load("planar_2r")
    case = thin_case(make_checker(robot, Scene("empty"), "coal"), "wall", 0.003, np.random.default_rng(2))

    class Blind:
        def __init__(self, checker) -> None: ...

        def prove(self, start, delta):
            return type("Proofs", (), {"free": np.ones(len(start), dtype=bool)})

    honest = list(judge(robot, case, 5))
    assert any(one.touches["coal"] for one in honest)
    assert not any(one.missed("fcl") or one.missed("coal") for one in honest)
    monkeypatch.setattr(bench, "EdgeProver", Blind)
    blind = list(judge(robot, case, 5))
    assert [one.missed("fcl") for one in blind] == [one.touches["coal"] for one in honest]
    assert [one.missed("coal") for one in blind] == [one.touches["coal"] for one in honest]
    text = next(one for one in blind if one.missed("fcl")).describe()
    assert text["certified by"] == ["fcl", "coal"]
    assert "Box" in text["obstacles"][0]["shape"]


def test_a_close_look_sees_what_ompls_rule_does_not() -> None:
    robot, scene, start, delta = _wall_between()
    checker = make_checker(robot, scene, "coal")
    assert checker.first_contact(states_by_ompls_rule(robot, start, delta)) is None
    touches, looks = look_closely(checker, start, delta)
    assert touches
    reach = float(checker.world.reach.motion(delta[None]).max())
    assert looks >= reach / 1e-4


@pytest.mark.parametrize("name", ["iiwa14", "panda", "planar_2r", "kinova"])
def test_the_rule_is_ompls(name: str) -> None:
    """OMPL's own count of segments, on a space made here as the planner makes it."""
    robot = load(name)
    space = _space(robot)
    info = ob.SpaceInformation(space)
    info.setStateValidityChecker(lambda state: True)
    info.setup()
    first, second = random_q(robot, 40, seed=1), random_q(robot, 40, seed=2)
    for a, b in zip(first, second, strict=True):
        parts = space.validSegmentCount(_state(info, robot, a), _state(info, robot, b))
        states = states_by_ompls_rule(robot, a, robot.difference(a, b))
        assert len(states) == parts + 1
        assert np.allclose(states[-1], a + robot.difference(a, b))
    assert len(states_by_ompls_rule(robot, first[0], np.zeros(robot.dof))) == 2


def _space(robot: Robot) -> ob.StateSpace:
    def real(lower: np.ndarray, upper: np.ndarray) -> ob.RealVectorStateSpace:
        part, bounds = ob.RealVectorStateSpace(len(lower)), ob.RealVectorBounds(len(lower))
        for k in range(len(lower)):
            bounds.setLow(k, float(lower[k]))
            bounds.setHigh(k, float(upper[k]))
        part.setBounds(bounds)
        return part

    if not robot.continuous.any():
        return real(robot.lower, robot.upper)
    space = ob.CompoundStateSpace()
    for k, wraps in enumerate(robot.continuous):
        part = ob.SO2StateSpace() if wraps else real(robot.lower[k : k + 1], robot.upper[k : k + 1])
        space.addSubspace(part, 1.0)
    return space


def _state(info: ob.SpaceInformation, robot: Robot, q: np.ndarray) -> ob.State:
    state = info.allocState()
    for k, value in enumerate(robot.normalise(q)):
        if not robot.continuous.any():
            state[k] = float(value)
        elif robot.continuous[k]:
            state[k].value = float(value)
        else:
            state[k][0] = float(value)
    return state


def test_misses_are_shouted() -> None:
    row = Row("panda", "wall", 1.0, 40, 0, 20, 22, 3, 20, 1, 0, 20, 0, 0, 1000, '[{"start": [1]}]', "here")
    text = to_markdown([row, replace(row, robot="ur5", fcl_missed=0, found="")], complete=True)
    assert "OMPL's default rule calls 44 free, of which **6 touch**" in text
    assert "40 with FCL, of which **1 touch**" in text
    assert '- Missed before panda: [{"start": [1]}]' in text
    assert "Missed before ur5" not in text
    assert "Software: here." in text


def test_wrong_input(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="at least 1 edge"):
        bench_misses(tmp_path, edges=0)
    with pytest.raises(OptionError, match="thicknesses"):
        bench_misses(tmp_path, thicknesses=(0.0,))
    with pytest.raises(RobotError, match="robots are"):
        bench_misses(tmp_path, robots=("marvin",))
    assert list(tmp_path.iterdir()) == []
