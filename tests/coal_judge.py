"""Coal as the independent opinion on contacts: it shares no code with the planner."""

from typing import Any

import coal
import numpy as np
import pinocchio as pin

from planner.collision.world import World
from planner.robot.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere


def coal_geometry(shape: Shape) -> Any:
    match shape:
        case Box(size):
            return coal.Box(*size)
        case Sphere(radius):
            return coal.Sphere(radius)
        case Cylinder(radius, length):
            return coal.Cylinder(radius, length)
        case Capsule(radius, length):
            return coal.Capsule(radius, length)
        case Mesh(vertices, triangles):
            model = coal.BVHModelOBBRSS()
            model.beginModel(len(triangles), len(vertices))
            model.addVertices(np.array(vertices))
            model.addTriangles(np.array(triangles))
            model.endModel()
            return model


def coal_transform(placement: np.ndarray) -> Any:
    return coal.Transform3s(np.array(placement[:3, :3]), np.array(placement[:3, 3]))


def coal_distance(a: Any, place_a: np.ndarray, b: Any, place_b: np.ndarray) -> float:
    """Signed distance of two coal geometries."""
    result = coal.DistanceResult()
    return coal.distance(a, coal_transform(place_a), b, coal_transform(place_b), coal.DistanceRequest(), result)


def coal_push(a: Any, b: Any, turn: np.ndarray, direction: np.ndarray, gap: float) -> np.ndarray | None:
    """The placement of b, turned by ``turn``, about ``gap`` away from a at the identity on its ``direction`` side."""
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = turn, 8.0 * direction
    for _ in range(6):
        result = coal.DistanceResult()
        args = a, coal_transform(np.eye(4)), b, coal_transform(placement), coal.DistanceRequest(), result
        distance = coal.distance(*args)
        apart = result.getNearestPoint2() - result.getNearestPoint1()
        length = np.linalg.norm(apart)
        if distance <= 0 or length < 1e-12:
            return None
        placement[:3, 3] -= apart / length * (distance - gap)
    return placement


class CoalWorld:
    """Every pair distance of a world by coal, at placements by Pinocchio."""

    def __init__(self, world: World) -> None:
        self.world, self.model = world, world.robot.model
        self.data = self.model.createData()
        self.bodies = [coal_geometry(body.shape) for body in world.bodies]
        self.obstacles = [coal_geometry(obstacle.shape) for obstacle in world.obstacles]
        self.still = [coal_transform(obstacle.placement) for obstacle in world.obstacles]
        self.count = len(self.bodies) * len(self.obstacles) + len(world.self_pairs)

    def place(self, q: np.ndarray) -> list[Any]:
        pin.forwardKinematics(self.model, self.data, np.asarray(q, dtype=float))
        return [coal_transform(self.data.oMi[b.joint].homogeneous @ b.placement) for b in self.world.bodies]

    def distances(self, q: np.ndarray, pairs: Any = None) -> np.ndarray:
        """(pairs,) signed distances."""
        placed = self.place(q)
        request, result = coal.DistanceRequest(), np.empty(self.count if pairs is None else len(pairs))
        for k, pair in enumerate(range(self.count) if pairs is None else pairs):
            i, j = self.world.members(int(pair))
            scene = self.world.is_scene_pair(int(pair))
            other, where = (self.obstacles[j], self.still[j]) if scene else (self.bodies[j], placed[j])
            result[k] = coal.distance(self.bodies[i], placed[i], other, where, request, coal.DistanceResult())
        return result

    def nearest_along(self, start: np.ndarray, delta: np.ndarray, coarse: float, fine: float) -> float:
        """The smallest distance along a segment looked at every ``coarse`` m of motion, every ``fine`` m where near."""
        motion = float(self.world.reach.motion(delta[None]).max(initial=0.0))
        s = np.linspace(0, 1, max(2, int(np.ceil(motion / coarse)) + 1))
        gaps = np.array([self.distances(start + t * delta).min(initial=np.inf) for t in s])
        lowest = float(gaps.min(initial=np.inf))
        pieces = int(np.ceil(coarse / fine))
        for k in range(len(s) - 1):
            if min(gaps[k], gaps[k + 1]) < 2 * coarse:
                for t in np.linspace(s[k], s[k + 1], pieces + 1)[1:-1]:
                    lowest = min(lowest, float(self.distances(start + t * delta).min(initial=np.inf)))
        return lowest
