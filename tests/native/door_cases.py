"""Random but valid input for the compiled code, and facts about its answers.

A case makes its input from a generator and a size, asks, looks at the answers, and returns them. Sizes have their edges
in them: no rows and one, one joint and many, no obstacles, no pairs, one arc.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, TypeAlias

import numpy as np

from planner.native.compiled import (
    Charge,
    NativeBounds,
    NativeBoxes,
    NativeChain,
    NativeConstraints,
    NativeGate,
    NativeWorld,
    chunk_curves,
    components,
    curve_chords,
    curve_knots,
    curve_next_ramp,
    curve_phases,
    group_rows,
    motion_mean,
    motion_shares,
    polynomial_extrema,
    polynomial_worst,
    ramp_quickest,
    stops_quickest,
)
from planner.native.refinement import Descent, EvenStretches, ProofSettings, RefinedPath, Step, descend, even_stretches
from planner.session.guard import Chunk
from planner.trajectory.trajectory import interpolate
from tests.random_shapes import random_pose

Rng: TypeAlias = np.random.Generator
LADDER = 0.05 * 1.3 ** np.arange(14)  # s that stops may take
REACH = 60.0  # m: farther than any point of an arm here is from any axis


@dataclass(frozen=True)
class Size:
    """How much of everything there is."""

    joints: int = 3
    rows: int = 5
    bodies: int = 3
    obstacles: int = 3
    nodes: int = 12


SIZES = {
    "small": Size(),
    "nothing": Size(1, 0, 1, 0, 1),
    "one": Size(1, 1, 1, 1, 2),
    "one body": Size(2, 4, 1, 3, 3),
    "no obstacles": Size(4, 3, 4, 0, 5),
    "many joints": Size(40, 7, 6, 2, 40),
    "many rows": Size(2, 300, 2, 1, 20_000),
}


def a_chain(rng: Rng, joints: int) -> NativeChain:
    """A tree of joints, turning ones and sliding ones."""
    axes = rng.normal(size=(joints, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    places = [random_pose(rng)[:3, :3] for _ in range(joints)]
    rotations = np.array(
        [[p, p @ crossing(a), p @ crossing(a) @ crossing(a)] for p, a in zip(places, axes, strict=True)]
    )
    slide = np.array([p @ a for p, a in zip(places, axes, strict=True)])
    parent = np.array([rng.integers(max(0, j - 2), j + 1) for j in range(joints)])
    return NativeChain(parent, rng.random(joints) < 0.3, rotations, rng.uniform(-0.3, 0.3, (joints, 3)), slide, axes)


def crossing(a: np.ndarray) -> np.ndarray:
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def states(rng: Rng, size: Size) -> np.ndarray:
    return rng.uniform(-2, 2, (size.rows, size.joints))


NUMBERS = 0.1, 0.8, 0.01, 2.0, 0.4, 0.02, 3.0, 0.1  # low, high, zeta, unit, beta, floor, longest, spacing


def tool_at(joint: int, point: Any, rows: tuple[int, int] = (0, 3)) -> Any:
    return np.array([joint]), np.asarray(point)[None], rows


def charge_of(
    rng: Rng, size: Size, chain: NativeChain, kind: int, chord: float = 0.0, numbers: Any = NUMBERS
) -> Charge:
    wraps = rng.random(size.joints) < 0.3
    return Charge(chain, (*numbers, chord), kind, kind == 2, 3 + 2 * kind, wraps, tool_at(size.joints, np.ones(3)))


def of_motion_costs(rng: Rng, size: Size) -> list[Any]:
    chain, q, found = a_chain(rng, size.joints), states(rng, size), []
    end = q + 2.0 * states(rng, size)
    for kind, chord in ((0, 0.0), (1, 0.3), (2, 0.0)):
        costs = charge_of(rng, size, chain, kind, chord).costs(q, end)
        assert (costs >= 0.4 * 0.01).all()  # beta of the least distance
        found.append(costs)
    plain = charge_of(rng, size, chain, 0, 0.3, (0.1, 0.8, 0.0, 2.0, 1.0, 0.0, 9.0, 0.1))
    near = q + 0.1 * states(rng, size)
    pieces = np.maximum(1, np.ceil(np.abs(near - q).sum(axis=1) / 0.3)).astype(int)
    lengths = chain.path_lengths(q, near - q, pieces, size.joints, np.ones(3))
    np.testing.assert_allclose(plain.costs(q, near), lengths / 2.0)
    return found


def of_a_chain(rng: Rng, size: Size) -> list[Any]:
    chain, q = a_chain(rng, size.joints), states(rng, size)
    joint, point = int(rng.integers(size.joints + 1)), rng.normal(size=3)
    rotation, position = chain.placements(q)
    assert np.abs(rotation @ rotation.swapaxes(-1, -2) - np.eye(3)).max(initial=0.0) < 1e-12
    points = chain.points(q, joint, point)
    assert np.abs((rotation[joint] * point).sum(axis=2) + position[joint] - points).max(initial=0.0) < 1e-12
    delta, pieces = 0.3 * states(rng, size), rng.integers(1, 9, size.rows)
    lengths = chain.path_lengths(q, delta, pieces, joint, point)
    ends = chain.points(q + delta, joint, point)
    assert (lengths >= np.linalg.norm(ends - points, axis=1) - 1e-12).all()
    w = [
        chain.manipulability_along(q, delta, np.array([0.0, 0.4, 1.0]), tool_at(joint, point, rows))
        for rows in ((0, 1), (0, 2), (0, 3), (0, 6), (3, 6))
    ]
    assert all(np.isfinite(one).all() and (one >= 0).all() for one in w)
    two = np.array([joint, size.joints]), np.stack([point, -point]), (0, 3)
    w.append(chain.manipulability(q, two))
    each = [chain.manipulability(q, tool_at(j, p)) for j, p in zip(*two[:2], strict=True)]
    assert np.array_equal(w[-1], np.minimum(*each))
    return [rotation, position, points, lengths, *w]


def of_inverse(rng: Rng, size: Size) -> list[Any]:
    chain, seeds, found = a_chain(rng, size.joints), np.asfortranarray(states(rng, size)), []
    tool, joint, lowest = random_pose(rng), size.joints, np.full(size.joints, -1.5)
    wraps = rng.random(size.joints) < 0.2
    for oriented in (False, True):
        target = random_pose(rng)
        limits, rows = (lowest, -lowest, wraps), np.array([6 if oriented else 3])
        one = np.array([joint]), tool[None], rows
        ends, distance, angle = chain.inverse(seeds, *one, target[None, None], limits, 15)
        tips = chain.points(ends, joint, tool[:3, 3])
        assert np.abs(np.linalg.norm(tips - target[:3, 3], axis=1) - distance).max(initial=0.0) < 1e-12
        assert (angle >= 0).all()
        assert oriented or not angle.any()
        moved = (ends != seeds).any(axis=1)
        assert (np.abs(ends[moved][:, ~wraps]) <= 1.5).all()
        found += [ends, distance, angle]
    return found


def of_boxes(rng: Rng, size: Size) -> list[Any]:
    chain, q, k = a_chain(rng, size.joints), states(rng, size), size.bodies
    joints, points, shifts = rng.integers(0, size.joints + 1, (2, k)), rng.normal(size=(k, 3)), rng.normal(size=(k, 3))
    turns = np.array([random_pose(rng)[:3, :3] for _ in range(k)])
    high = rng.uniform(0.2, 3.0, (k, 3))
    rows, local = NativeBoxes(chain, joints[0], points, joints[1], turns, shifts, -high, high).hits(q)
    assert (np.abs(local) < high[rows[:, 1]]).all()
    assert len(np.unique(rows, axis=0)) == len(rows)
    nothing = NativeBoxes(chain, *(array[:0] for array in (joints[0], points, joints[1], turns, shifts, -high, high)))
    assert len(nothing.hits(q)[0]) == 0
    return [rows, local]


def of_keeping(rng: Rng, size: Size) -> list[Any]:
    """Two frames, one with half-spaces and one with balls; projected states satisfy them."""
    chain, q, k = a_chain(rng, size.joints), states(rng, size), 1 + size.bodies
    joints, placements = rng.integers(0, size.joints + 1, 2), np.array([random_pose(rng) for _ in range(2)])
    wraps, ball = rng.random(size.joints) < 0.2, np.arange(2 * k) >= k
    rows, limits = rng.normal(size=(4 * k, 12)), rng.uniform(0.5, 2.0, 2 * k) * np.where(ball, 1.0, -1.0)
    free = np.full(size.joints, -2.5), np.full(size.joints, 2.5), wraps
    pieces = np.full(2, k), np.where(ball, 3, 1), ball, rows, rng.normal(size=4 * k), limits, np.ones(2 * k)
    world = np.full(2, -1), np.tile(np.eye(4), (2, 1, 1))
    keeping = NativeConstraints(chain, joints, placements, *pieces, free, *world)
    rotation, position = chain.placements(q)
    there, good = keeping.projected(q, rng.random(len(q)), 1e-9, 20)
    assert (np.abs(there[(there != q).any(axis=1)][:, ~wraps]) <= 2.5).all()
    found, (turns, shifts) = [there, good], chain.placements(there)
    for frame, joint in enumerate(joints):
        turned = turns[joint] @ placements[frame, :3, :3], shifts[joint] + turns[joint] @ placements[frame, :3, 3]
        found.append(keeping.slack(frame, *turned))
        assert (found[-1][good] >= -1e-8).all()
    curves = np.stack([there, 0.1 * rng.normal(size=q.shape), 0.01 * rng.normal(size=q.shape)], axis=1)
    per_joint = np.ones((2, size.joints)), np.ones((2, size.joints, size.joints)), np.ones((2, size.joints))
    proven = keeping.proven(curves, (*per_joint, *np.full((2, 2 * k), 3.0)), 1e-9, 1e-6)
    assert not proven[~good].any()
    found.append(proven)
    empty = tuple(array[:0] for array in pieces)
    none = NativeConstraints(chain, joints[:0], placements[:0], *empty, free, *(array[:0] for array in world))
    assert none.projected(q, np.ones(len(q)), 0.0, 3)[1].all()
    return [*found, rotation, position]


def add_shape(rng: Rng, world: NativeWorld, joint: int) -> tuple[int, np.ndarray, float]:
    """A small shape near the origin; points and a radius around them that hold it."""
    kind, middle = int(rng.integers(3)), rng.uniform(-1, 1, 3) * (2.0 if joint < 0 else 0.1)
    if kind == 0:
        points, radius = middle + rng.uniform(-0.1, 0.1, (int(rng.integers(1, 9)), 3)), float(rng.uniform(0, 0.1))
        return world.add_hull(joint, points, radius), points, radius
    if kind == 1:
        turn, radius, half = random_pose(rng)[:3, :3], float(rng.uniform(0.02, 0.1)), float(rng.uniform(0.02, 0.2))
        number = world.add_cylinder(joint, middle, half * turn[:, 2], radius * turn[:, :2].T)
        return number, middle + half * np.array([turn[:, 2], -turn[:, 2]]), radius
    triangles = middle + rng.uniform(-0.1, 0.1, (int(rng.integers(1, 6)), 3, 3))
    points = triangles.reshape(-1, 3)
    return world.add_surface(joint, points, triangles, float(rng.choice([0.05, np.inf]))), points, 0.0


def add_body(rng: Rng, world: NativeWorld, joint: int) -> None:
    number, points, radius = add_shape(rng, world, joint)
    middle = points.mean(axis=0)
    radii = np.array([np.linalg.norm(points - middle, axis=1).max() + radius])
    world.add_spheres(number, np.repeat(middle[None], 2, axis=0), np.repeat(radii, 2))


def add_obstacle(rng: Rng, world: NativeWorld, moves: bool) -> None:
    number, points, radius = add_shape(rng, world, -1)
    low, high = points.min(axis=0) - radius, points.max(axis=0) + radius
    world.add_target(number, np.eye(3), 0.5 * (low + high), 0.5 * (high - low), 0.0, False)
    if rng.random() < 0.5:
        across = float(np.linalg.norm(points - points.mean(axis=0), axis=1).max()) + 2.0 * radius
        world.add_target(number, np.eye(3), points.mean(axis=0), np.array([across, 0.0, across]), 0.0, True)
    if moves:
        n = int(rng.integers(1, 4))
        turns = np.array([np.eye(3)] * n)
        shifts, times = rng.uniform(-1, 1, (n, 3)), np.arange(n, dtype=float)
        speeds = np.linalg.norm(np.diff(shifts, axis=0), axis=1)
        size = float(np.linalg.norm(points, axis=1).max()) + radius
        world.set_motion(number, times, turns, shifts, np.zeros((n - 1, 3)), np.zeros(n - 1), speeds, size)
    world.set_speed_limit(number, 0.01 if rng.random() < 0.5 else 0.0)


def a_world(rng: Rng, size: Size, moves: bool = False) -> tuple[NativeChain, NativeWorld]:
    chain = a_chain(rng, size.joints)
    world = NativeWorld(chain, float(rng.choice([0.0, 0.01])))
    for joint in rng.integers(0, size.joints + 1, size.bodies):
        add_body(rng, world, int(joint))
    for _ in range(size.obstacles):
        add_obstacle(rng, world, moves)
    set_pairs(rng, world, size)
    return chain, world


def set_pairs(rng: Rng, world: NativeWorld, size: Size) -> None:
    scene = [(b, size.bodies + o) for b in range(size.bodies) for o in range(size.obstacles)]
    own = [(a, b) for b in range(size.bodies) for a in range(b)]
    pairs = np.array(scene + own, dtype=np.int64).reshape(-1, 2)
    world.set_pairs(pairs, rng.random(len(pairs)) < 0.9)


def bounds_of(world: NativeWorld) -> NativeBounds:
    reach = np.full((world.pairs, world.dof), REACH)
    return world.bounds(reach, body_reach_of(world), np.zeros(world.pairs, dtype=bool))


def body_reach_of(world: NativeWorld) -> np.ndarray:
    return np.full((world.bodies, world.dof), REACH)


def of_distances(rng: Rng, size: Size) -> list[Any]:
    chain, world = a_world(rng, size)
    placed = chain.placements(states(rng, size))
    coarse = world.coarse(*placed)
    count = 3 * size.rows if world.pairs else 0
    rows, pairs = (rng.integers(0, max(most, 1), count) for most in (size.rows, world.pairs))
    close = world.close(*placed, rows, pairs)
    assert (close >= 0).all()
    assert np.isfinite(close).all()
    known = np.isfinite(coarse[rows, pairs])
    assert (coarse[rows, pairs][known] <= close[known] + 1e-5).all()  # of convex ones; surfaces lie deeper still
    normals = world.planes(*placed, rows, pairs)
    assert np.isfinite(normals).all()
    return [coarse, close, normals]


def of_clouds(rng: Rng, size: Size) -> list[Any]:
    """Balls against the distance of every one of them, and a grid of ties; groups of rows against sets of rows."""
    count, chain, found = 1 + 60 * size.rows, a_chain(rng, 1), []
    for step in (0.0, 0.05):
        points = rng.uniform(-1, 1, (count, 3)) * [1.0, 1.0, 1e-3]
        points = np.round(points / step) * step if step else points
        for side in (0.0, 0.3):
            first, which, spread = group_rows(points, side)
            assert spread == np.linalg.norm(points - points[first[which]], axis=1).max()
            keys = [tuple(row) for row in (np.floor(points / side) if side else points).tolist()]
            assert first.tolist() == [keys.index(key) for key in dict.fromkeys(keys)]
            assert [keys[k] for k in first[which]] == keys
            found += [first, which]
        few = points[:150]
        starts, near = components(few, 0.1), np.linalg.norm(few[:, None] - few, axis=2) <= 0.2
        reached = near
        for _ in range(10):
            reached = reached.astype(float) @ reached > 0
        assert reached[starts].any(axis=0).all()
        radius, boxes, cell = float(rng.choice([0.0, 0.02])), int(rng.integers(1, 40)), rng.uniform(0, 0.02, (1, 8, 3))
        for sets in (points[:, None], points[:, None] + cell):
            world = NativeWorld(chain, 0.0)
            world.add_hull(1, np.zeros((1, 3)), 0.0)
            world.add_spheres(0, np.zeros((1, 3)), np.zeros(1))
            world.add_cloud(-1, sets, radius, boxes)
            world.set_pairs(np.array([[0, 1]]), np.ones(1, dtype=bool))
            placed = chain.placements(rng.uniform(-2, 2, (8, 1)))
            close, coarse = world.close(*placed, np.arange(8), np.zeros(8, dtype=int)), world.coarse(*placed)[:, 0]
            corners = np.linalg.norm(sets.reshape(-1, 1, 3) - placed[1][1], axis=2).min(axis=0) - radius
            assert (coarse <= close + 1e-9).all()
            assert (close <= np.maximum(corners, 0.0) + 1e-9).all()
            reach = 1e-6 if sets.shape[1] == 1 else 0.04  # the size of a cell
            assert (close >= corners - reach).all()
            found += [close, coarse]
    return found


def of_glances(rng: Rng, size: Size) -> list[Any]:
    _, world = a_world(rng, size)
    q, delta = states(rng, size), 0.2 * states(rng, size)
    near = [world.first_near(row[None]) == 0 for row in q]
    first = world.first_near(q)
    assert first == (near.index(True) if True in near else len(q))
    looks = []
    for a, by in zip(q[:20], delta[:20], strict=True):
        looks.append(world.look(bounds_of(world), 2.0)(a, by))
        assert not looks[-1] or world.first_near(a + np.array([[0.5], [1.0]]) * by) == 2
    return [first, looks]


def of_tree_paths(rng: Rng, size: Size) -> list[Any]:
    chain, world = a_world(rng, size)
    dof, found = size.joints, []
    point, wraps = rng.normal(size=3), rng.random(dof) < 0.3
    starts, goals = (rng.uniform(-2, 2, (count, dof)) for count in (1, 2))
    for longest, floor, limit in ((np.inf, 0.0, 60), (np.inf, 1e-3, 60), (8.0, 0.0, 60), (np.inf, 0.0, 0)):
        space = (np.full(dof, -2.5), np.full(dof, 2.5)), wraps, longest, tool_at(dof, point), floor, 0.2
        path, looked_at = world.tree_path(bounds_of(world), *space, starts, goals, 0.7, 0.5, 5, limit)
        assert 0 <= looked_at <= limit
        if path is not None:
            assert world.first_near(path[1:-1]) == len(path[1:-1])
            assert floor == 0.0 or (chain.manipulability(path, tool_at(dof, point)) >= floor).all()
        found += [np.zeros(0) if path is None else path, looked_at]
    return found


def of_walks(rng: Rng, size: Size) -> list[Any]:
    _, world = a_world(rng, size)
    found, few = [], replace(size, rows=min(size.rows, 40))
    for degree in (0, 1, 2, 5, 16):
        curves = np.stack([states(rng, few) * 0.02**k for k in range(degree + 1)], axis=1)
        parts, moved, shares = world.walk(bounds_of(world), curves, 0.1)
        assert (parts >= 1).all()
        assert len(moved) == parts.sum()
        assert ((moved >= 0) & (moved <= 0.1 * (1 + 1e-9))).all()
        assert ((shares >= 0) & (shares <= 2)).all()
        found += [parts, moved, shares]
    return found


def of_proofs(rng: Rng, size: Size) -> list[Any]:
    _, world = a_world(rng, size)
    found, few = [], replace(size, rows=min(size.rows, 40))
    for degree in (0, 1, 2, 5, 16):
        curves = np.stack([states(rng, few) * 0.02**k for k in range(degree + 1)], axis=1)
        verdict, pair, samples, clearance, where = world.prove(bounds_of(world), curves, 1e-3)
        require_verdicts(world, verdict, pair, samples, where)
        free = verdict == 0
        assert (clearance[free] > -1e-9).all()
        powers = rng.random((5, 1)) ** np.arange(degree + 1)
        assert (
            world.first_near(np.einsum("sk,mkd->msd", powers, curves[free]).reshape(-1, few.joints)) == 5 * free.sum()
        )
        found += [verdict, pair, samples, clearance, where]
    return found


def require_verdicts(world: NativeWorld, verdict: Any, pair: Any, samples: Any, where: Any) -> None:
    assert np.isin(verdict, (0, 2)).all()
    assert (pair[verdict == 0] == -1).all()
    assert ((pair >= -1) & (pair < world.pairs)).all()
    assert (samples >= 1).all()
    assert ((where >= 0) & (where <= 1)).all()


def of_proofs_in_time(rng: Rng, size: Size) -> list[Any]:
    """A world that takes over items of another one, with their motions, gives the same answers."""
    chain, world = a_world(rng, size, moves=True)
    again, seed = NativeWorld(chain, 0.0), int(rng.integers(1000))
    numbers = [again.take(world, item) for item in range(size.bodies + size.obstacles)]
    assert numbers == list(range(size.bodies + size.obstacles))
    set_pairs(np.random.default_rng(seed), again, size)
    few = replace(size, rows=min(size.rows, 40))
    curves = np.stack([states(rng, few), 0.02 * states(rng, few)], axis=1)
    spans = np.abs(rng.normal(size=(few.rows, 3))) * [1.0, 0.1, 0.01]
    taken = again.prove(bounds_of(again), curves, 1e-3, spans)
    require_verdicts(again, taken[0], taken[1], taken[2], taken[4])
    once_more = NativeWorld(chain, 0.0)
    for item in range(size.bodies + size.obstacles):
        once_more.take(again, item)
    set_pairs(np.random.default_rng(seed), once_more, size)
    for one, same in zip(taken, once_more.prove(bounds_of(again), curves, 1e-3, spans), strict=True):
        np.testing.assert_array_equal(one, same)
    return list(taken)


def of_chunks(rng: Rng, size: Size) -> list[Any]:
    """Curves one after the other, each beginning where the last one ends."""
    found, few = [], replace(size, rows=min(size.rows, 40))
    for moves in (False, True):
        _, world = a_world(rng, size, moves=moves)
        knots = np.cumsum(0.02 * states(rng, replace(few, rows=few.rows + 1)), axis=0)
        for degree in (1, 5):
            curves = np.stack([0.01 * states(rng, few) * 0.02**k for k in range(degree + 1)], axis=1)
            curves[:, 0], curves[:, 1] = knots[:-1], np.diff(knots, axis=0)
            spans = np.column_stack([0.05 * np.arange(few.rows), np.full((few.rows, 2), [0.05, 0.0])])
            verdict, pair, where = world.prove_together(bounds_of(world), curves, 1e-3, spans if moves else None)
            free = int((verdict == 0).sum())
            assert (verdict[:free] == 0).all()
            assert (verdict[free:] == 2).all()
            assert ((pair >= -1) & (pair < world.pairs)).all()
            assert ((where >= 0) & (where <= 1)).all()
            powers = rng.random((9, 1)) ** np.arange(degree + 1)
            along = np.einsum("sk,mkd->msd", powers, curves[:free]).reshape(-1, few.joints)
            assert moves or world.first_near(along) == 9 * free
            found += [verdict, pair, where]
    return found


def of_stops(rng: Rng, size: Size) -> list[Any]:
    """Begin where the arm is, end at rest, and keep the limits by the exact extrema of their derivatives."""
    n, dof = size.rows, size.joints
    start = rng.normal(size=(n, 3, dof)) * np.array([1.0, 0.5, 2.0])[:, None]
    positions, limits = (np.full(dof, -2.5), np.full(dof, 2.5)), np.repeat([[1.0], [4.0], [60.0]], dof, axis=1)
    pieces, seconds, broken = stops_quickest(start, LADDER, limits, positions)
    np.testing.assert_array_equal(pieces[:, 0, 0], start[:, 0])
    assert ((broken >= 0) & (broken < [4, dof])).all()
    moving, powers = seconds[:, 1] > 0, np.arange(5)
    for factor in (powers, powers * (powers - 1)):  # velocity and acceleration in the end
        np.testing.assert_allclose((factor[:, None] * pieces[moving, 1]).sum(axis=1), 0.0, atol=1e-9)
    for k, half in np.argwhere(seconds > 0):
        c = pieces[k, half]
        for order in range(4):
            least, largest = polynomial_extrema(c[None])
            low, high = positions if order == 0 else (-limits[order - 1], limits[order - 1])
            assert (least >= low - 1e-9).all()
            assert (largest <= high + 1e-9).all()
            c = c[1:] * np.arange(1, len(c))[:, None] / seconds[k, half]
    return [pieces, seconds, broken]


def a_gate(chain: NativeChain, world: NativeWorld, limits: Any = None, apart: float = 0.0) -> NativeGate:
    n, wide = world.dof, np.full(world.dof, 50.0)
    none, points, turns = np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 3, 3))
    boxes = NativeBoxes(chain, none, points, none, turns, points, points, points)
    limits = (np.full((3, n), np.inf), -wide, wide) if limits is None else limits
    state = -wide, wide, np.zeros(n, dtype=bool)
    return NativeGate(world, bounds_of(world), boxes, False, 1e-3, limits, state, LADDER, apart, 1e4)


def of_gates(rng: Rng, size: Size) -> list[Any]:
    """A check in one call is the sum of its steps."""
    found, few = [], replace(size, rows=min(size.rows, 12) + 2)
    for share in (0.02, 0.2, 3.0):
        chain, world = a_world(rng, size)
        wide, most = np.full(world.dof, 50.0), np.repeat([[0.5], [2.0], [40.0]], world.dof, axis=1)
        gate, times = a_gate(chain, world, (most, -wide, wide)), np.cumsum(rng.uniform(0.1, 0.3, few.rows))
        times = np.round(times * 1e9) / 1e9
        q, v = np.cumsum(share * 0.1 * states(rng, few), axis=0), share * states(rng, few)
        judged, made = gate.check(few.rows, 2, 0, np.concatenate([times, q, v], axis=None), True)
        clock, seconds, pieces, knots, _ = Chunk.from_native(judged, made, few.rows, 2, world.dof)
        np.testing.assert_allclose(seconds, np.diff(times), rtol=1e-9)
        np.testing.assert_array_equal(pieces, interpolate(seconds[:, None], q, v))
        np.testing.assert_array_equal(knots[:, :2], np.stack([q, v], axis=1))
        stops, durations, _ = stops_quickest(knots[1:], LADDER, most, (-wide, wide))
        count = judged.pieces
        assert (durations[:count, 1] > 0).all()
        for k, order in product(range(count), (1, 2)):
            assert polynomial_worst(pieces[k][None], seconds[k : k + 1], order, most[order - 1], 0.0)[0] <= 1.0
        curves, _, what = chunk_curves(pieces[:count], clock[: count + 1], (stops[:count], durations[:count]), None)
        free = int((world.prove_together(bounds_of(world), curves, 1e-3)[0] == 0).sum()) if count else 0
        assert (judged.usable, judged.proven) == (1, free)
        if free < len(curves):
            assert (judged.reason, judged.piece, judged.place) == (3, *what[free])
        else:
            assert judged.reason == (0 if count == len(pieces) else 2)
        found += [judged.proven, judged.reason, judged.piece, pieces, knots]
    return found


def of_choices(rng: Rng, size: Size) -> list[Any]:
    _, world = a_world(rng, size)
    items = min(size.rows, 40)
    alternatives = rng.integers(0, 4, items)
    motions = rng.integers(0, 3, int(alternatives.sum()))
    some = replace(size, rows=int(motions.sum()))
    curves = np.stack([states(rng, some), 0.02 * states(rng, some)], axis=1)
    begin = rng.integers(0, 2, items)
    chosen, clearance, samples = world.first_proven(bounds_of(world), curves, motions, alternatives, begin, 1e-3)
    assert ((chosen == -1) | ((chosen >= begin) & (chosen < alternatives))).all()
    proven = world.prove(bounds_of(world), curves, 1e-3)[0] == 0
    assert proven[samples >= 0].all()
    points = np.cumsum(0.02 * states(rng, replace(size, rows=max(1, items))), axis=0)
    price = np.where(rng.random((len(points), len(points))) < 0.1, np.inf, rng.uniform(0, 1, (len(points),) * 2))
    rows, gaps, looks = world.cheapest_chain(bounds_of(world), points, price, 1e-3)
    assert rows.tolist() == cheapest_proven(world, points, price)
    return [chosen, clearance, samples, rows, gaps, looks]


def cheapest_proven(world: NativeWorld, points: Any, price: Any) -> list[int]:
    """Row after row of the cheapest chain, where every motion that skips a row is proven beforehand."""
    i, j = np.triu_indices(len(points), 2)
    motions = np.stack([points[i], points[j] - points[i]], axis=1)
    refused = world.prove(bounds_of(world), motions, 1e-3)[0] != 0
    price = price.copy()
    price[i[refused], j[refused]] = np.inf
    ways: list[tuple[float, list[int]]] = [(0.0, [0])]
    for row in range(1, len(points)):
        ways.append(min((total + price[way[-1], row], [*way, row]) for total, way in ways))
    return ways[-1][1] if np.isfinite(ways[-1][0]) else [*range(len(points))]


def of_refinement(rng: Rng, size: Size) -> list[Any]:
    """All sweeps and tries at once are as one after the other, and the new path is proven."""
    size = replace(size, rows=min(size.rows + 2, 30))
    (chain, world), dof, found = a_world(rng, size), size.joints, []
    path = np.cumsum(0.02 * states(rng, size), axis=0)
    mixes, limits = rng.random((4, 2)), (np.full(dof, -1.0), np.full(dof, 1.0))
    ends = np.sort(rng.permuted(np.tile(np.arange(len(path)), (5, 1)), axis=1)[:, :2], axis=1)
    for kind, first in ((0, 1), (1, 2), (2, 1)):
        judge = ProofSettings(world, bounds_of(world), 1e-3, charge_of(rng, size, chain, kind))
        draws = rng.normal(size=(5, max(0, (len(path) - 1) // 2), 3, dof + 1))
        sweeps = Descent(path, first, Step(0.1, 0.2), 0.05, 0.02, limits, mixes, draws, 4)
        (at_once, *_), one_by_one = descend(judge, sweeps), sweeps
        for k in range(len(draws)):
            turn = one_by_one._replace(first=1 + (first - 1 + k) % 2, draws=draws[k : k + 1])
            moved, _, step = descend(judge, turn)
            one_by_one = one_by_one._replace(path=moved.path, step=step)
        assert np.array_equal(one_by_one.path, at_once.path)
        joints, shares = rng.random((3, 5, dof)) < 0.5, rng.uniform(0.5, 1.0, (3, 5))
        tries = EvenStretches(path, np.array([ends] * 3), joints, shares, -0.1, 4)
        straightened = even_stretches(judge, tries)
        found += of_refined(world, path, at_once) + of_refined(world, path, straightened)
    return found


def of_refined(world: NativeWorld, before: Any, refined: RefinedPath) -> list[Any]:
    """What a refined path is: its ends stay, new motions are proven as it says, others are as they were."""
    path, _, clearance, samples = refined
    new, old = np.flatnonzero(samples >= 0), np.flatnonzero(samples < 0)
    assert np.array_equal(path[[0, -1]], before[[0, -1]])
    for rows in (old, old + 1):
        assert np.array_equal(path[rows], before[rows])
    starts, delta = path[new], np.diff(path, axis=0)[new]
    verdict, _, counts, gaps, _ = world.prove(bounds_of(world), np.stack([starts, delta], 1), 1e-3)
    assert not verdict.any()
    assert np.array_equal(counts, samples[new])
    assert np.array_equal(gaps, clearance[new])
    return [path, refined.chosen, clearance[new], samples]


def of_curves(rng: Rng, size: Size) -> list[Any]:
    """Lines, and parabolas that are ramps of all joints alike, so that motions along them are quick to tell."""
    m, dof = size.rows + 1, size.joints
    pieces = rng.normal(size=(m, 3, dof))
    pieces[:, 2] = np.where(np.arange(m) % 2, 0.3, 0.0)[:, None] * pieces[:, 1]
    stop, (velocity, acceleration) = rng.random(m) < 0.3, rng.uniform(0.5, 2.0, (2, dof))
    phases = curve_phases(pieces, stop, rng.integers(1, 30, m), velocity, acceleration)
    duration = phases[:, 4].sum()
    assert ((phases[:, 1] >= -1e-12) & (phases[:, 1] <= 1) & (phases[:, 2] >= 0) & (phases[:, 4] > 0)).all()
    clock, q, qd, piece = curve_knots(pieces, stop, phases, 1.5, 20_000_000, 50_000)
    assert (np.diff(clock) >= 50_000).all()
    assert 1.5 * duration - 1e-6 * len(phases) <= clock[-1] / 1e9
    assert not qd[[0, -1]].any()
    mean = motion_mean(clock, q, qd, 20_000_000, 50_000)
    assert np.array_equal(mean[1][[0, -1]], q[[0, -1]])
    assert mean[0][-1] == clock[-1] + 20_000_000
    moments = np.sort(rng.uniform(0, duration, (8, 2)), axis=1)
    limits, positions = (velocity, acceleration), (np.full(dof, -9.0), np.full(dof, 9.0))
    _, world = a_world(rng, size)
    bounds, shares = bounds_of(world), np.array([0.6, 0.9, 40.0])
    found = curve_next_ramp(world, bounds, 1e-3, pieces, phases, moments, shares, limits, positions)
    assert found is None or not world.prove(bounds, found[3], 1e-3)[0].any()
    most, seconds = rng.uniform(0.1, 2.0, (3, dof)), np.diff(mean[0]) / 1e9
    shares, quintics = motion_shares(*mean, most), interpolate(seconds[:, None], *mean[1:])
    exact = [polynomial_worst(quintics, seconds, k, most[k - 1], 1.0)[0] for k in (1, 2, 3)]
    np.testing.assert_allclose(shares, exact, rtol=1e-9)
    points, walked = curve_chords(pieces, 16, 0.1)
    np.testing.assert_allclose(points[[0, -1]], [pieces[0, 0], pieces[-1].sum(axis=0)])
    assert (walked >= np.linalg.norm(np.diff(points, axis=0), axis=1) - 1e-9).all()
    ramp = ramp_quickest((q[0], qd[0]), (q[-1], qd[-1]), np.array([1.0, 30.0, 1e3]), velocity, acceleration)
    assert not len(ramp) or np.array_equal(ramp[0, 0], q[0])
    ramps = [ramp] if found is None else [ramp, np.array(found[:1]), found[3]]
    return [phases, clock, q, qd, piece, *mean, shares, points, walked, *ramps]


CASES: dict[str, Callable[[Rng, Size], list[Any]]] = {
    case.__name__: case
    for case in (
        of_a_chain, of_inverse, of_boxes, of_keeping, of_distances, of_clouds, of_glances, of_tree_paths, of_walks,
        of_proofs, of_proofs_in_time, of_chunks, of_stops, of_gates, of_choices,
        of_motion_costs, of_refinement, of_curves,
    )
}  # fmt: skip
