"""Roadmaps on disk: the same bytes, and one sentence for files that hold no roadmap."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import FileError
from planner.problem.request import PlanRequest, WorldRequest
from planner.query.query import make_checker_for
from planner.roadmap.build import build_roadmap
from planner.roadmap.roadmap import DTYPES, Roadmap
from planner.roadmap.storage import load_roadmap, reopen_plan, same_world, save_roadmap, summarize
from tests.random_shapes import QUICK
from tests.worlds import post_roadmap

ROADMAP = post_roadmap(30)


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("roadmap") / "roadmap.npz"
    save_roadmap(ROADMAP, path)
    return path.read_bytes()


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("damaged")


def test_round_trip(content, tmp_path):
    (tmp_path / "a.npz").write_bytes(content)
    back = load_roadmap(tmp_path / "a.npz")
    for name in DTYPES:
        ours, theirs = getattr(back, name), getattr(ROADMAP, name)
        np.testing.assert_array_equal(ours, theirs)
        assert ours.dtype == theirs.dtype
        assert not ours.flags.writeable
    assert (back.scale, back.origin, back.sha256) == (ROADMAP.scale, ROADMAP.origin, ROADMAP.sha256)
    save_roadmap(back, tmp_path / "b.npz")
    assert (tmp_path / "b.npz").read_bytes() == content
    assert sorted(os.listdir(tmp_path)) == ["a.npz", "b.npz"]


def load_or_refuse(path: Path) -> None:
    """A changed file is refused, or its content is unchanged (unused bytes of a zip)."""
    try:
        roadmap = load_roadmap(path)
    except FileError:
        return
    assert roadmap.sha256 == ROADMAP.sha256


@QUICK
@given(st.data())
def test_flipped_and_missing_bytes(content, folder, data):
    changed = bytearray(content)
    for place in data.draw(st.lists(st.integers(0, len(content) - 1), min_size=1, max_size=4)):
        changed[place] ^= data.draw(st.integers(1, 255))
    cut = data.draw(st.integers(0, len(content)))
    for name, damaged in (("flipped.npz", bytes(changed)), ("cut.npz", content[:cut]), ("noise.npz", os.urandom(99))):
        (folder / name).write_bytes(damaged)
        load_or_refuse(folder / name)


def test_other_files_and_versions_are_refused(tmp_path, monkeypatch):
    with pytest.raises(FileError, match="not found: 'planner roadmap build' makes one"):
        load_roadmap(tmp_path / "none.npz")
    with pytest.raises(FileError, match="Is a directory"):
        load_roadmap(tmp_path)
    (tmp_path / "text.npz").write_text("# a page")
    with pytest.raises(
        FileError, match=r"text\.npz is damaged or no roadmap \(the file is not an \.npz archive\): build it again"
    ):
        load_roadmap(tmp_path / "text.npz")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(FileError, match=r"other\.npz is damaged or no roadmap"):
        load_roadmap(tmp_path / "other.npz")
    monkeypatch.setattr("planner.roadmap.storage.VERSION", 3)
    save_roadmap(ROADMAP, tmp_path / "old.npz")
    monkeypatch.undo()
    with pytest.raises(FileError, match="has format version 3, this planner reads 4"):
        load_roadmap(tmp_path / "old.npz")


def of_window(margin: float = 0.01) -> Roadmap:
    """A roadmap of built-in names."""
    checker = make_checker_for(WorldRequest("planar_2r", "window", margin=margin))
    return build_roadmap(checker.robot, checker, [0.0, 0.5], [0.1, 0.5], nodes=6)


def test_a_plans_world_is_the_one_that_its_roadmap_was_proven_in(tmp_path: Path) -> None:
    roadmap, file = of_window(), tmp_path / "roadmap.npz"
    save_roadmap(roadmap, file)
    config = PlanRequest.from_options(robot="planar_2r", scene="window", margin=0.01).config()
    assert same_world(roadmap, reopen_plan(config, file))
    for other in ({"scene": "empty"}, {"margin": 0.02}, {"base": "0,0,1"}):
        with pytest.raises(FileError, match=r"was proven for another robot or scene than its plan\.json names"):
            reopen_plan(config | other, file)
    with pytest.raises(FileError, match=r"options in the plan.json next to .* are invalid"):
        reopen_plan(config | {"margin": "wide"}, file)


def test_counts_are_those_of_the_arrays() -> None:
    roadmap = post_roadmap()
    unproven = roadmap.proven.copy()
    unproven[:3] = False
    some = replace(roadmap, proven=unproven, clearance=np.where(unproven, roadmap.clearance, 99.0))
    told = summarize(some)
    neighbours = [sum(node in edge for edge in some.edges.tolist()) for node in range(len(some.nodes))]
    assert told["degree"] == {"min": min(neighbours), "mean": np.mean(neighbours), "max": max(neighbours)}
    assert told["edges_certified"] == len(some.edges) - 3
    assert told["clearance"]["max"] == some.clearance[3:].max() < 99.0  # what has no proof promises nothing
    assert sum(told["components"]) == len(some.nodes)
    assert told["components"] == sorted(told["components"], reverse=True)
    assert told["manipulability"]["0"] == some.manipulability.min()
    assert told["manipulability"]["1"] == some.manipulability.max()
