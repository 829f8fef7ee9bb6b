"""One method on one network: the same x from all that run the dynamics, and what blocks exchange."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from benchmarks.gabf.case import KERNEL, LAW, geometric_network
from benchmarks.partition import case
from benchmarks.partition.case import ACTORS, DIJKSTRA, HERE, WHOLE, main, measure
from planner import gabf

STEPS = 300_000


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("network") / "network.npz"
    gabf.write_network(geometric_network(150, 6, np.random.default_rng(5)), path)
    return path


@pytest.fixture(scope="module")
def solved(file: Path) -> gabf.CostToGo:
    return gabf.solve(gabf.read_network(file, KERNEL), LAW)


def digest(x: np.ndarray) -> str:
    return hashlib.sha256(x.tobytes()).hexdigest()[:16]


def test_one_process_and_blocks_end_at_the_same_x(file: Path, solved: gabf.CostToGo) -> None:
    whole, here = measure(file, WHOLE, 3, STEPS), measure(file, HERE, 3, STEPS)
    for facts in (whole, here):
        assert facts["x_sha256"] == digest(solved.x)
        assert (facts["steps"], facts["settled"]) == (solved.steps, True)
        assert facts["mib"] >= facts["load_mib"] > 0
        assert facts["prepare_s"] > 0
    assert "told" not in whole
    assert here["told"] > here["boundary"] > 0
    assert here["calls"] > 3 * solved.steps  # both halves of a step, and its end


def test_steps_are_bounded(file: Path, solved: gabf.CostToGo) -> None:
    facts = measure(file, HERE, 2, 3)
    assert 1 <= facts["steps"] <= 3  # those that are rejected count too
    assert not facts["settled"]
    assert facts["x_sha256"] != digest(solved.x)


def test_dijkstra_has_no_steps(file: Path, solved: gabf.CostToGo, monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[np.ndarray] = []
    search = case.dijkstra_on
    monkeypatch.setattr(case, "dijkstra_on", lambda network: lambda: found.append(search(network)()) or found[0])
    facts = measure(file, DIJKSTRA, 2, STEPS)
    assert facts["x_sha256"] == digest(found[0])
    np.testing.assert_allclose(found[0], solved.x, rtol=1e-12)
    assert "steps" not in facts


def test_actors_end_at_the_same_x(
    file: Path, solved: gabf.CostToGo, scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    @contextmanager
    def threads(workers: int) -> Iterator[str]:
        asked.append(workers)
        yield scheduler

    monkeypatch.setattr(case, "local_cluster", threads)
    facts = measure(file, ACTORS, 2, STEPS)
    assert asked == [2]
    assert (facts["x_sha256"], facts["steps"]) == (digest(solved.x), solved.steps)
    assert facts["told"] > facts["boundary"] > 0
    assert facts["worker_mib"] > 0


def test_the_process_writes_what_it_measured(file: Path, solved: gabf.CostToGo, tmp_path: Path) -> None:
    main(str(file), str(tmp_path / "row.json"), json.dumps({"method": HERE, "blocks": 2, "steps": STEPS}))
    assert json.loads((tmp_path / "row.json").read_text())["x_sha256"] == digest(solved.x)
