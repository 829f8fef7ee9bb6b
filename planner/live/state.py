"""What a live page shows: the session's plan, the world it holds in, and what came before."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import choices
from planner.base.hashing import content_hash
from planner.kinematics.forward import tool_positions
from planner.models.poses import quaternion_of
from planner.models.shapes import Cylinder
from planner.planning.result import Plan
from planner.roadmap.roadmap import Roadmap
from planner.session.session import Session, Snapshot
from planner.view.canvas import Canvas
from planner.view.drawing import place_obstacles
from planner.view.page import Content, draw_answer, field_data, page
from planner.view.shown_path import ShownPath, path_rows


@dataclass(frozen=True)
class Question:
    """What is asked: start and goal as text, and beta."""

    start: str
    goal: str
    beta: float


@dataclass(frozen=True, eq=False)
class State:
    """A moment that can be come back to: session, question and plan, and the roadmap that the plan speaks of."""

    snapshot: Snapshot
    question: Question
    plan: Plan
    start: Floats  # (dof,) where the path begins, or would

    @staticmethod
    def of(session: Session, question: Question, plan: Plan) -> State:
        start = plan.path[0] if plan.solved else plan.roadmap.nodes[plan.roadmap.starts[0]]
        return State(session.snapshot(), question, plan, start)

    @property
    def roadmap(self) -> Roadmap:
        """All nodes, and the edges that are not blocked: those that were opened are proven before their use."""
        return self.plan.roadmap

    @property
    def message(self) -> str:
        """The outcome as a sentence; a path here has no times, so what moves is named as left aside."""
        said = self.plan.message
        moving = self.snapshot.now.live.scene.moving
        if not moving:
            return said
        return f"{said} Left aside, because they move: {choices(o.name for o in moving)}; 'planner plan' plans in time."

    @property
    def goal_position(self) -> Floats:
        """(3,) m: where the tool is at the goal that is reached, or at the first one."""
        robot = self.snapshot.now.live.checker.robot
        q = self.plan.path[-1] if self.plan.solved else self.roadmap.nodes[self.roadmap.goals[0]]
        return tool_positions(robot, q)[0]


@dataclass(frozen=True)
class Report:
    """What came of a change: rows of a table, and how long each part of it took (s)."""

    what: str
    rows: list[tuple[str, str]]
    seconds: dict[str, float]


def page_of(state: State, report: Report, undo: int, **fixed: Any) -> str:
    """The whole page; ``fixed`` is what never changes: token and names of files."""
    content = _content(state)
    live = _live(state, None, report, undo) | {"fixed": fixed}
    return page(replace(content, live=live))


def update_of(state: State, before: State | None, report: Report, undo: int) -> dict[str, Any]:
    """What changes in the page: commands for its viewer, and data in place of what it had."""
    canvas, content = Canvas(), _content(state)
    for path in ("paths", "gap", "start", "goal"):
        canvas.delete(path)
    place_obstacles(canvas, content.scene)
    data = draw_answer(canvas, content)
    scene, lengths = canvas.packed()
    live = _live(state, before, report, undo)
    return {"scene": scene, "lengths": lengths, "data": {**data, "beta": state.question.beta}, "live": live}


def _content(state: State) -> Content:
    live, plan = state.snapshot.now.live, state.plan
    robot, paths = live.checker.robot, []
    if plan.cost is not None:
        costs = plan.cost.manipulability, plan.cost.distance
        rows = [("total cost", f"{plan.cost.total:.4f}"), *path_rows(robot, plan.path, *costs)]
        paths = [ShownPath(plan.path, rows, costs=costs, cost_to_go=state.plan.node_costs)]
    return Content(
        robot,
        live.scene,
        state.message,
        state.start,
        roadmap=state.roadmap,
        cost_to_go=state.plan.node_costs,
        paths=paths,
        beta=state.question.beta,
        reason=plan.reason,
        live={},  # what a page of it has is added later; all of the roadmap is drawn, at first and at every change
    )


def _live(state: State, before: State | None, report: Report, undo: int) -> dict[str, Any]:
    """What the page's own controls stand at.

    ``drawn`` is a hash of the obstacles wherever they are: a page that has drawn others has to be drawn anew, also
    where another viewer's request brought them.
    """
    scene = state.snapshot.now.live.scene
    obstacles = [
        {
            "name": item.name,
            "position": item.placement[:3, 3].tolist(),
            "quaternion": quaternion_of(item.placement[:3, :3]),
            "upright": isinstance(item.shape, Cylinder),
        }
        for item in scene.obstacles
    ]
    return {
        "drawn": content_hash(part for item in scene.obstacles for part in (item.name, *item.shape.content())),
        "obstacles": obstacles,
        "goal": state.goal_position.tolist(),
        "start": state.start.tolist(),
        "red": sorted(frozenset() if state.plan.reason is None else state.plan.reason.names),
        "before": None if before is None else field_data(field_before(state, before)),
        "what": report.what,
        "report": report.rows,
        "seconds": {name: round(value, 4) for name, value in report.seconds.items()},
        "undo": undo,
    }


def field_before(state: State, before: State) -> Floats | None:
    """(n,) the cost-to-go that the roadmap's nodes had before; inf for those that are new."""
    field = before.plan.node_costs
    if field is None:
        return None
    known = {q.tobytes(): float(x) for q, x in zip(before.roadmap.nodes, field, strict=True)}
    return np.array([known.get(q.tobytes(), np.inf) for q in state.roadmap.nodes])


def report_of(
    what: str, state: State, before: State | None, seconds: dict[str, float], told: Sequence[tuple[str, str]] = ()
) -> Report:
    """What a change of the world meant for edges, field and cost, and before that what else is ``told`` of it."""
    done = state.plan.replanned
    edges = done.edges
    proofs = state.snapshot.now.live.proofs
    rows = [
        *told,
        ("proven again", f"{edges.proven} edges"),
        ("to be proven before use", f"{int(proofs.open.sum())} of {len(proofs.known)} edges"),
        ("lost, regained", f"{edges.removed}, {edges.regained} edges"),
        ("nodes grown", str(done.nodes_grown)),
        ("field healed", f"{done.raised} nodes raised, {done.updates} updates"),
    ]
    if before is not None:
        rows.append(("cost-to-go changed", _changed(state, before)))
        rows.append(("total cost", f"{_total(before)} → {_total(state)}"))
    return Report(what, rows, seconds)


def _changed(state: State, before: State) -> str:
    old, new = field_before(state, before), state.plan.node_costs
    if old is None or new is None:
        return "no field"
    both = np.isfinite(old) & np.isfinite(new)
    apart = np.abs(new[both] - old[both])
    return f"at {int((apart > 1e-9).sum())} nodes, by {apart.max(initial=0.0):.3g} at most"


def _total(state: State) -> str:
    return "no path" if state.plan.cost is None else f"{state.plan.cost.total:.4f}"
