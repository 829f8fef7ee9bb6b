"""What a live page shows: a moment's ends, the field before it, and the report of a change, against the session."""

from __future__ import annotations

import base64
import gzip
import json
from pathlib import Path

import numpy as np
import pytest

from planner.kinematics.forward import tool_positions
from planner.live.state import Question, State, field_before, page_of, report_of, update_of
from planner.session.session import Session
from tests.browser import page_data
from tests.live.controllers import SCENE
from tests.worlds import load

QUESTION = Question("start", "goal", 0.5)
SECONDS = {"planning": 0.123456}


def make_session(folder: Path) -> Session:
    (folder / "scene.yaml").write_text(SCENE)
    return Session("planar_2r", str(folder / "scene.yaml"), nodes=80, collision="coal", join_motions=500)


def states_of(folder: Path, *position: float) -> tuple[State, State]:
    """Before and after the post was moved to a place."""
    session = make_session(folder)
    before = State.of(session, QUESTION, session.plan("start", "goal", 0.5))
    session.move("post", position, quaternion=[0, 0, 0, 1])
    return before, State.of(session, QUESTION, session.replan())


@pytest.fixture(scope="module")
def moved(tmp_path_factory: pytest.TempPathFactory) -> tuple[State, State]:
    return states_of(tmp_path_factory.mktemp("moved"), 0.65, 0.0, 0.0)


@pytest.fixture(scope="module")
def separated(tmp_path_factory: pytest.TempPathFactory) -> State:
    """The post in the way of the first link: there is no path."""
    return states_of(tmp_path_factory.mktemp("separated"), 0.3, 0.0, 0.0)[1]


def field_of(state: State) -> dict[bytes, float]:
    """Node to cost-to-go; nodes that came after the field are left out."""
    assert state.plan.cost_to_go is not None
    return {q.tobytes(): float(x) for q, x in zip(state.roadmap.nodes, state.plan.cost_to_go.x, strict=False)}


def test_a_state_keeps_its_moment(moved: tuple[State, State]) -> None:
    before, after = moved
    places = [state.snapshot.now.live.scene.obstacles[0].placement[:3, 3].tolist() for state in moved]
    assert places == [[0.75, 0.0, 0.0], [0.65, 0.0, 0.0]]
    assert before.plan.path is not after.plan.path
    counts = [(len(state.roadmap.edges), state.snapshot.now.live.proofs.blocked) for state in moved]
    assert all(edges == blocked.size - blocked.sum() for edges, blocked in counts)
    assert counts[1][0] < counts[0][0]


def test_the_ends_are_the_paths_or_those_of_the_question(moved: tuple[State, State], separated: State) -> None:
    for state in (*moved, separated):
        np.testing.assert_allclose(state.start, [-1.0, 0.8], atol=1e-12)
        tool = tool_positions(load("planar_2r"), np.array([1.0, -0.8]))[0]
        np.testing.assert_allclose(state.goal_position, tool, atol=1e-12)
    assert [state.plan.solved for state in (*moved, separated)] == [True, True, False]


def test_the_field_before_is_the_field_that_was(moved: tuple[State, State]) -> None:
    before, after = moved
    np.testing.assert_array_equal(field_before(after, before), list(field_of(before).values()))
    assert field_of(before) != field_of(after)


def test_nodes_that_are_new_had_no_cost_to_go(tmp_path: Path) -> None:
    session = make_session(tmp_path)
    before = State.of(session, QUESTION, session.plan("start", "goal", 0.5))
    asked = Question("q:-1.2,0.9", "goal", 0.5)
    after = State.of(session, asked, session.plan(asked.start, asked.goal, asked.beta))
    was, found = field_of(before), field_before(after, before)
    np.testing.assert_array_equal(found, [was.get(q.tobytes(), np.inf) for q in after.roadmap.nodes])
    assert found is not None
    assert np.isinf(found).any()
    np.testing.assert_allclose(after.start, [-1.2, 0.9], atol=1e-12)


def test_the_report_says_what_has_changed(moved: tuple[State, State]) -> None:
    before, after = moved
    rows = dict(report_of("moved", after, before, SECONDS).rows)
    was, now = field_of(before), field_of(after)
    apart = [abs(now[q] - was[q]) for q in now if q in was and np.isfinite([now[q], was[q]]).all()]
    count = sum(value > 1e-9 for value in apart)
    assert count > 0
    assert rows["cost-to-go changed"] == f"at {count} nodes, by {max(apart):.3g} at most"
    totals = [field_of(state)[state.start.tobytes()] for state in moved]
    assert rows["total cost"] == f"{totals[0]:.4f} → {totals[1]:.4f}"
    edges, proofs = after.plan.edges, after.snapshot.now.live.proofs
    assert rows["proven again"] == f"{edges.proven} edges"
    assert rows["to be proven before use"] == f"{proofs.open.sum()} of {len(proofs.known)} edges"
    assert rows["field healed"].startswith(f"{after.plan.replanned.raised} nodes raised")
    assert "total cost" not in dict(report_of("opened", before, None, SECONDS).rows)


def test_the_report_without_a_path_has_no_number_for_it(moved: tuple[State, State], separated: State) -> None:
    rows = dict(report_of("moved", separated, moved[0], SECONDS).rows)
    assert rows["total cost"].endswith("→ no path")


def test_the_page_is_whole_and_what_is_fixed_stands_in_it(moved: tuple[State, State], tmp_path: Path) -> None:
    state = moved[1]
    file = tmp_path / "page.html"
    file.write_text(page_of(state, report_of("opened", state, None, SECONDS), 3, token="secret", file="saved.yaml"))
    data = page_data(file)
    live = data["live"]
    assert live["fixed"] == {"token": "secret", "file": "saved.yaml"}
    assert (live["undo"], live["what"], live["seconds"], live["before"]) == (3, "opened", {"planning": 0.1235}, None)
    assert [(item["name"], item["upright"]) for item in live["obstacles"]] == [("post", False), ("drum", True)]
    assert live["obstacles"][0]["position"] == [0.65, 0.0, 0.0]
    np.testing.assert_allclose(data["paths"][0]["waypoints"], state.plan.path, atol=1e-4)


def test_an_update_holds_what_changes_and_no_more(moved: tuple[State, State]) -> None:
    before, after = moved
    made = json.loads(json.dumps(update_of(after, before, report_of("moved", after, before, SECONDS), 1)))
    commands = gzip.decompress(base64.b64decode(made["scene"]))
    assert [sum(lengths) for lengths in made["lengths"]] == [len(commands)]
    assert made["data"]["beta"] == 0.5
    assert made["live"]["red"] == []
    assert "fixed" not in made["live"]
    assert len(made["live"]["before"]) == len(made["data"]["cost"]) == len(after.roadmap.nodes)
    assert made["data"]["message"] == after.plan.outcome.value


def test_an_update_draws_all_of_a_large_roadmap_as_the_page_did(
    moved: tuple[State, State], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("planner.view.drawing.MOST_EDGES", 5)
    before, after = moved
    update = update_of(after, before, report_of("moved", after, before, SECONDS), 1)
    assert update["data"]["roadmap"]["edges"] == after.roadmap.edges.tolist()
    assert len(update["live"]["before"]) == len(update["data"]["cost"]) == len(after.roadmap.nodes)


def test_an_update_without_a_path_blames_what_separates(moved: tuple[State, State], separated: State) -> None:
    made = update_of(separated, None, report_of("moved", separated, None, SECONDS), 1)
    assert separated.plan.reason is not None
    assert made["live"]["red"] == ["post"]
    assert made["data"]["message"] == separated.plan.reason.sentence
    assert made["data"]["paths"][0]["numbers"] == []
