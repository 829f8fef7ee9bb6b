"""A forest of proven motions: first paths, then RRT from all of their nodes (LaValle 1998)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Floats, Ints, length
from planner.base.progress import QUIET, Progress
from planner.base.resolutions import MOTION_IN_GROWTH
from planner.collision.edge_prover import EdgeProver
from planner.kinematics.manipulability import manipulability
from planner.roadmap.edges import MotionChecker
from planner.roadmap.first_path import FirstPathSearch, JoinSettings, find_shorter_path
from planner.roadmap.forest import Forest
from planner.roadmap.ompl_planners import JointSpace, Tree, TreePlanners
from planner.robot.robot import Robot


@dataclass(frozen=True)
class GrowthSettings:
    """The step and the budget of a tree, in counts instead of seconds, so that a run can be repeated.

    ``range`` (rad): longer steps cross free space sooner, shorter ones enter narrow passages. ``join_motions``: the
    most motions that the search for a first path may check, 8000 per joint by default; ``shortcuts``: the partial
    shortcuts of that path to try. ``motions_per_node``: the most motions that RRT may check per node to add. ``floor``:
    manipulability w that all motions exceed, except for those that lead up to it from a start or goal below; 0 for
    none.
    """

    range: float = 0.8
    join_motions: int | None = None
    shortcuts: int = 16
    motions_per_node: int = 20
    floor: float = 0.0


_JOIN_PER_JOINT = 8000  # motions
_SHORTER_PER_NODE, _SHORTER = 5, 10_000  # most motions that the search for shorter first paths may check
_NEARLY_STRAIGHT = 1.1  # times the distance of the nearest start and goal: shorter paths are short enough
_SHARE_OF_PATHS = 0.3  # of the nodes, for first paths
_BATCH = 250  # nodes at least that a tree grows before its motions are proven
_ABOVE = 0.02  # relative slack above the floor: between two sampled states w may dip
ROADMAP = "roadmap"  # a stage of progress


@dataclass(frozen=True, eq=False)
class Growth:
    """A forest of proven motions: ``nodes`` (n, dof), starts first, then goals; ``edges`` (m, 2)."""

    nodes: Floats
    edges: Ints
    starts: Ints
    goals: Ints
    joined: bool  # a start and a goal, by a straight motion or by RRTConnect
    motions: int  # motions checked


def grow(
    prover: EdgeProver,
    starts: Floats,
    goals: Floats,
    nodes: int,
    seed: int,
    settings: GrowthSettings,
    progress: Progress = QUIET,
) -> Growth:
    """Grow about ``nodes`` configurations around first paths from ``starts`` to ``goals``, (k, dof) each.

    These are all proven straight motions, and where there is none the path of RRTConnect, and more that it finds where
    a shorter one may pass: the first path is often several times as long as necessary, and no refinement leads from one
    way around the obstacles to another. If the first path needs more than ``nodes``, all of it stays. The same seed
    gives the same growth.
    """
    rng = np.random.default_rng(seed)
    motions, forest = MotionChecker(prover, (1.0 + _ABOVE) * settings.floor), Forest()
    first = np.array([forest.add(q) for q in starts], dtype=np.int64)
    last = np.array([forest.add(q) for q in goals], dtype=np.int64)
    search = FirstPathSearch(motions, join_settings(settings, prover.robot), rng, progress)
    if settings.floor > 0 and len(goals):  # without goals, ``starts`` are a tree whose paths reach the floor already
        starts, goals = _ascend(forest, motions, starts), _ascend(forest, motions, goals)
    straight = search.find_straight(starts, goals)
    spine = None if straight or np.isin(first, last).any() else search.join(starts, goals)
    joining = straight if spine is None else [spine]
    for path in joining:
        forest.add_path(path)
    checked = search.checked
    if spine is not None:
        checked += _add_shorter_paths(motions, forest, starts, goals, spine, nodes, settings, rng, progress)
    checked += grow_tree(motions, forest, nodes - len(forest), settings, rng, progress)
    return Growth(forest.nodes(), forest.edges(), first, last, bool(joining), checked)


def join_settings(settings: GrowthSettings, robot: Robot) -> JoinSettings:
    """Return the budget of the search for a first path of a ``robot``."""
    return JoinSettings(settings.range, settings.join_motions or _JOIN_PER_JOINT * robot.dof, settings.shortcuts)


def _add_shorter_paths(
    motions: MotionChecker,
    forest: Forest,
    starts: Floats,
    goals: Floats,
    path: Floats,
    nodes: int,
    settings: GrowthSettings,
    rng: np.random.Generator,
    progress: Progress,
) -> int:
    """Add paths to ``forest`` that may be shorter than all before; return the number of checked motions."""
    robot, checked, longest = motions.robot, 0, _length(motions.robot, path)
    enough = _NEARLY_STRAIGHT * float(np.linalg.norm(robot.difference(starts[:, None], goals[None]), axis=2).min())
    limit = min(_SHORTER_PER_NODE * nodes, _SHORTER)
    join = join_settings(settings, robot)
    while longest > enough and checked < limit and len(forest) < _SHARE_OF_PATHS * nodes and not progress.stopped:
        within_limit = replace(join, motions=limit - checked)
        shorter, count = find_shorter_path(motions, within_limit, starts, goals, longest, rng, progress)
        checked += max(count, 1)  # counts a search that could not begin, so that the loop ends
        progress("shorter paths", min(checked, limit), limit)
        if shorter is not None:
            forest.add_path(shorter)
            longest = min(longest, _length(robot, shorter))
    progress("shorter paths", checked, checked)
    return checked


def _length(robot: Robot, path: Floats) -> float:
    return float(np.linalg.norm(robot.difference(path[:-1], path[1:]), axis=1).sum())


def _ascend(forest: Forest, motions: MotionChecker, ends: Floats) -> Floats:
    """Return the states (m, dof) where paths up from ``ends`` (k, dof) reach the floor; add the paths."""
    paths = [ascend_manipulability(motions.prover, q, motions.floor) for q in ends]
    for path in paths:
        forest.add_path(path)
    tops = np.array([path[-1] for path in paths]).reshape(ends.shape)
    return tops[manipulability(motions.robot, tops) >= motions.floor]  # no motion may leave the others


def grow_tree(
    motions: MotionChecker,
    forest: Forest,
    count: int,
    settings: GrowthSettings,
    rng: np.random.Generator,
    progress: Progress = QUIET,
) -> int:
    """Grow RRT from every node of ``forest``, until ``count`` are added or too many motions were refused.

    Motions are sampled in a few states while the tree grows and proven many at a time afterwards, which takes half as
    long as one by one. Branches behind a motion without a proof are dropped, and the tree grows on. Returns the number
    of motions that were checked.
    """
    full, checked, limit = len(forest) + count, 0, settings.motions_per_node * count
    most = 0  # reported nodes, some of which may lack a proof
    while len(forest) < full and checked < limit and not progress.stopped:
        before = len(forest)
        check = motions.make_state_check(MOTION_IN_GROWTH)
        with TreePlanners(JointSpace.from_robot(motions.robot), check, rng, progress, motions.constraints) as planners:
            planners.on_accept = lambda new, old=before, most=most: progress(ROADMAP, max(old + new, most), full)
            batch = min(full - before, max(_BATCH, before // 4))
            tree = planners.rrt(forest.nodes(), motions.step(settings.range), batch, limit - checked)
            most = max(most, before + planners.accepted)
        checked += max(planners.checked, 1)  # counts a tree that could not begin, so that the loop ends
        _add_proven(motions, forest, tree)
    return checked


def _add_proven(motions: MotionChecker, forest: Forest, tree: Tree) -> None:
    """Add to ``forest`` the proven motions of ``tree`` that are connected to it; its nodes begin the tree."""
    if not len(tree.edges):
        return
    motions_of_tree = tree.nodes[tree.edges]
    a, b = np.moveaxis(motions_of_tree, 1, 0)
    proven = motions.prover.free(a, motions.robot.difference(a, b), motions.resolution).tolist()
    joined = [True] * len(forest) + [False] * (len(tree.nodes) - len(forest))
    rows = []
    for row, ((parent, child), is_proven) in enumerate(zip(tree.edges.tolist(), proven, strict=True)):
        if is_proven and joined[parent]:
            rows.append(row)
            joined[child] = True
    forest.add_edges(motions_of_tree[rows])


_STEP = 0.05  # rad
_STEPS = 80
_TRIES = 12  # directions near the steepest one, where that is blocked
_SPREAD = 1.4  # length of the random addition to the steepest direction, which has length 1
_STATES = np.linspace(0.0, 1.0, 6)[1:]  # of a step, at which w must rise
_EPS = 1e-4  # rad, finite differences


def ascend_manipulability(prover: EdgeProver, q: Floats, floor: float) -> Floats:
    """Return a path (k, dof) from ``q`` up to w = ``floor``, or as far as small proven steps lead.

    w rises from each sampled state to the next. The last row is below ``floor`` where every step up is blocked.
    """
    robot, rng = prover.robot, np.random.default_rng(0)
    rows, w = [q], float(manipulability(robot, q[None])[0])
    while w < floor and len(rows) <= _STEPS:
        end = _step(prover, rows[-1], w, rng)
        if end is None:
            break
        rows.append(end)
        w = float(manipulability(robot, end[None])[0])
    return robot.normalise(np.array(rows))


def _step(prover: EdgeProver, q: Floats, w: float, rng: np.random.Generator) -> Floats | None:
    """Return the end of the proven step that gains most w, among those along which w rises."""
    robot = prover.robot
    slope = manipulability(robot, q + _EPS * np.eye(robot.dof)) - w
    uphill = slope / max(length(slope), 1e-300)
    directions = np.vstack([uphill, uphill + _SPREAD * rng.normal(size=(_TRIES, robot.dof)) / np.sqrt(robot.dof)])
    directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-300)
    ends = q + _STEP * directions
    ends = np.where(robot.continuous, ends, np.clip(ends, robot.lower, robot.upper))
    delta = ends - q
    along = manipulability(robot, (q + _STATES[:, None, None] * delta).reshape(-1, robot.dof))
    along = np.vstack([np.full(len(ends), w), along.reshape(len(_STATES), -1)])
    rising = np.flatnonzero((np.diff(along, axis=0) > 0).all(axis=0))
    for row in rising[np.argsort(-along[-1, rising], kind="stable")]:
        if prover.free(q[None], delta[row][None])[0]:
            return ends[row]
    return None
