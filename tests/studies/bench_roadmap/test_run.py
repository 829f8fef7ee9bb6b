"""``planner bench roadmap``: every method has its row, its peers are asked the same, and the aims are judged."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planner.base.errors import OptionError, RobotError, SceneError
from planner.base.progress import QUIET, Progress
from planner.base.request import WorldRequest
from planner.collision.checker import is_free
from planner.paths.measure import path_contact
from planner.studies.bench_roadmap import run as bench
from planner.studies.bench_roadmap.case import answer, plain_check, random_pairs
from planner.studies.bench_roadmap.report import (
    CHECKS,
    MEASURED,
    NOT_INSTALLED,
    OMPL,
    OMPL_PLAIN,
    OURS,
    PEERS,
    PYROBOPLAN,
    Row,
    aims,
    to_markdown,
)
from planner.studies.bench_roadmap.run import METHODS, bench_roadmap
from planner.studies.process import run_module
from planner.studies.table import read_rows
from tests.worlds import POST_GOAL, POST_START, checker_of, load, make_post, post_roadmap, random_q

# the interface of pyroboplan 1.3.1 that is used, over a straight line: it links nothing but start and goal
FAKE = """
class PRMPlannerOptions:
    def __init__(self, max_neighbor_radius, max_construction_nodes, construction_timeout, rng_seed):
        self.nodes, self.seed = max_construction_nodes, rng_seed
        assert construction_timeout > 1e9

class Node:
    def __init__(self, q):
        self.q = q

class Edge:
    def __init__(self, a, b):
        self.nodeA, self.nodeB = a, b

class Graph:
    pass

class PRMPlanner:
    def __init__(self, model, collision_model, options):
        import numpy as np
        assert len(collision_model.collisionPairs) > 0
        self.options, self.graph = options, Graph()
        self.graph.nodes, self.graph.edges = [], set()
        self.random = np.random.default_rng(options.seed)
        self.model, self.resets = model, 0

    def construct_roadmap(self):
        print("chatter")
        low, high = self.model.lowerPositionLimit, self.model.upperPositionLimit
        self.graph.nodes = [Node(self.random.uniform(low, high)) for _ in range(self.options.nodes)]
        self.graph.edges = {Edge(b, a) for a, b in zip(self.graph.nodes, self.graph.nodes[1:])}

    def reset(self):
        self.resets += 1

    def plan(self, start, goal):
        print("chatter")
        return [start, goal] if self.resets % 2 else None
"""


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> WorldRequest:
    """planar_2r beside a post: room enough for everybody."""
    scene = tmp_path_factory.mktemp("scene") / "post.yaml"
    scene.write_text("obstacles: [{name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}]\n")
    return WorldRequest("planar_2r", str(scene), collision="coal")


@pytest.fixture(scope="module")
def folder(world: WorldRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("roadmap")
    assert bench_roadmap(place, world, nodes=40, queries=4).complete
    return place


def rows_of(folder: Path) -> dict[str, Row]:
    return {row.method: row for row in read_rows(folder / "roadmap.csv", Row, "planner bench roadmap")}


def test_every_method_has_a_row(folder: Path) -> None:
    rows = rows_of(folder)
    assert set(rows) == {OURS, *PEERS, *CHECKS}
    ours, ompl, plain = rows[OURS], rows[OMPL], rows[OMPL_PLAIN]
    assert ours.outcome == ompl.outcome == plain.outcome == MEASURED
    assert ours.proven == ours.edges
    assert ours.touching == ours.contacts == 0
    assert ours.solved == ompl.solved == plain.solved == 4
    for row in (ours, ompl, plain):
        assert row.nodes is not None
        assert row.edges is not None
        assert 38 <= row.nodes <= 60
        assert row.edges >= 30
        assert row.looked_at == min(row.edges, 200)
        assert 0 < (row.query_ms or 0) <= (row.query_worst_ms or 0)
    assert (ours.many_ms or 0) > 0
    for name in CHECKS:
        row = rows[name]
        assert 0 < (row.check_edge_us or 0) < 1e5
    text = (folder / "roadmap.md").read_text()
    assert "| gabf-planner |" in text
    assert "| FCL checks |" in text


def test_what_is_not_installed_is_said(folder: Path) -> None:
    row = rows_of(folder)[PYROBOPLAN]
    if row.outcome == NOT_INSTALLED:
        assert "pip install --no-deps pyroboplan" in (folder / "roadmap.md").read_text()
    else:
        assert row.nodes == 40


def test_pyroboplan_is_asked_through_its_interface(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "pyroboplan" / "planning"
    package.mkdir(parents=True)
    (package.parent / "__init__.py").write_text("")
    (package / "__init__.py").write_text("")
    (package / "prm.py").write_text(FAKE)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    asked = {"method": PYROBOPLAN, "robot": "planar_2r", "scene": "window", "collision": "coal", "nodes": 12}
    options = json.dumps(asked | {"queries": 3, "seed": 1})
    ended = run_module("planner.studies.bench_roadmap.case", [str(tmp_path / "rows.json"), options])
    assert ended.code == 0, ended.last_words
    columns = json.loads((tmp_path / "rows.json").read_text())[PYROBOPLAN]
    assert (columns["nodes"], columns["edges"], columns["looked_at"]) == (12, 11, 11)
    assert columns["solved"] == 2  # of the three, every other one
    assert columns["touching"] > 0  # nothing in it looks at obstacles


def test_rows_that_are_there_are_not_measured_again(
    folder: Path, world: WorldRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = []
    monkeypatch.setattr(bench, "_measure", lambda blank, stop: measured.append(blank.method) or [])
    again = bench_roadmap(folder, world, nodes=40, queries=4)
    assert (measured, again.complete, len(again.rows)) == ([], True, len(METHODS) + 1)
    assert not bench_roadmap(folder, world, nodes=41, queries=4).complete
    assert measured == [OURS]


def test_a_method_that_takes_too_long_is_killed(world: WorldRequest, tmp_path: Path) -> None:
    found = bench_roadmap(tmp_path, world, nodes=40, queries=1, time_limit=0.05)
    assert found.complete
    assert all(row.outcome == "timed out" for row in found.rows)
    assert "- OMPL PRM, our checker: timed out. Killed after 0.05 s." in (tmp_path / "roadmap.md").read_text()


def test_a_crash_is_a_row(tmp_path: Path) -> None:
    """OMPL's PRM is not compared on continuous joints, and says so."""
    blank = Row(OMPL, "kinova", "empty", "coal", 10, 1, 0, 60.0, "here", "crashed")
    row = bench._measure(blank, QUIET)[0]
    assert row.outcome == "crashed"
    assert "kinova has continuous joints" in row.message
    assert bench._measure(blank, Progress(stop=lambda: True)) == []


def test_one_field_answers_many_starts() -> None:
    roadmap, checker = post_roadmap(), make_post()
    starts = POST_START + np.array([[0.0, 0.0], [0.1, -0.2], [-0.2, 0.1]])
    paths = answer(roadmap, checker, starts, POST_GOAL)
    alone = [answer(roadmap, checker, start[None], POST_GOAL)[0] for start in starts]
    for path, start, single in zip(paths, starts, alone, strict=True):
        assert np.allclose(path[0], start)
        assert np.allclose(path[-1], POST_GOAL)
        assert path_contact(checker, path) is None
        assert np.allclose(single[-1], POST_GOAL)


def test_queries_are_free_and_the_same_for_all() -> None:
    checker = checker_of("planar_2r", "window")
    pairs = random_pairs(checker, 5, seed=2)
    assert pairs.shape == (5, 2, 2)
    assert all(is_free(checker, q) for q in pairs.reshape(-1, 2))
    assert np.array_equal(pairs, random_pairs(checker, 5, seed=2))
    assert not np.array_equal(pairs, random_pairs(checker, 5, seed=3))


def test_the_plain_check_says_the_same() -> None:
    checker = checker_of("panda", "shelf")
    free = plain_check(checker)
    q = random_q(load("panda"), 60, seed=6)
    said = [free(row) for row in q]
    assert said == [is_free(checker, row) for row in q]
    assert 0 < sum(said) < 60


def test_a_scene_without_room_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("planner.studies.bench_roadmap.case.is_free", lambda checker, q: False)
    with pytest.raises(SceneError, match="only 0 are free"):
        random_pairs(checker_of("planar_2r", "window"), 2, seed=0)


def row(method: str, **more) -> Row:
    plain = Row(method, "panda", "shelf", "coal", 1000, 20, 0, 600.0, "here", MEASURED, build_s=2.0, query_ms=20.0)
    return replace(plain, **{"nodes": 1000, "edges": 2000, "touching": 0, "looked_at": 200, "contacts": 0} | more)


def test_aims_are_met_and_missed() -> None:
    good = [row(OURS), row(OMPL, build_s=21.0), row(PYROBOPLAN, build_s=60.0)]
    assert [(aim.confirmed, aim.of) for aim in aims(good)] == [(2, 2), (1, 1), (1, 1)]
    assert "OMPL PRM, our checker: 10.5 times" in aims(good)[0].note
    bad = [replace(good[0], query_ms=51.0, touching=1), replace(good[1], build_s=19.0)]
    assert [aim.confirmed for aim in aims(bad)] == [0, 0, 0]
    assert [aim.of for aim in aims([])] == [0, 0, 0]
    text = to_markdown(good)
    assert "| OMPL PRM, our checker | 21 | 10.5 |" in text
    assert to_markdown([], complete=False).startswith("# planner bench roadmap")


def test_wrong_input(world: WorldRequest, tmp_path: Path) -> None:
    with pytest.raises(OptionError, match="at least one query"):
        bench_roadmap(tmp_path, world, queries=0)
    with pytest.raises(RobotError, match="robots are"):
        bench_roadmap(tmp_path, WorldRequest("marvin", "shelf"))
    with pytest.raises(SceneError, match="scenes are"):
        bench_roadmap(tmp_path, WorldRequest("panda", "moon"))
    assert list(tmp_path.iterdir()) == []
