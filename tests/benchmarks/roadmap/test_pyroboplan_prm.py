"""pyroboplan's PRM, asked through its interface."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.bench import run_module
from benchmarks.roadmap.report import (
    PYROBOPLAN,
)

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


def test_pyroboplan_is_asked_through_its_interface(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "pyroboplan" / "planning"
    package.mkdir(parents=True)
    (package.parent / "__init__.py").write_text("")
    (package / "__init__.py").write_text("")
    (package / "prm.py").write_text(FAKE)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    asked = {"method": PYROBOPLAN, "robot": "planar_2r", "scene": "window", "collision": "coal", "nodes": 12}
    options = json.dumps(asked | {"queries": 3, "seed": 1})
    ended = run_module("benchmarks.roadmap.case", [str(tmp_path / "rows.json"), options])
    assert ended.code == 0, ended.last_words
    columns = json.loads((tmp_path / "rows.json").read_text())[PYROBOPLAN]
    assert (columns["nodes"], columns["edges"], columns["looked_at"]) == (12, 11, 11)
    assert columns["solved"] == 2  # of the three, every other one
    assert columns["touching"] > 0  # nothing in it looks at obstacles
