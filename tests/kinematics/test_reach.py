"""No point of a body moves further than its reach times the joint motion."""

import numpy as np
import pinocchio as pin
import pytest

from planner.robot.reach import Reach
from planner.robot.robot import Robot
from planner.robot.shapes import Box, Cylinder
from tests.random_shapes import moved, points_in
from tests.worlds import ROBOTS, checker_of, geometry_xml, joint_xml, link_xml, load, random_q

SLACK = 1e-9


def placements(robot, q):
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    return [data.oMi[j].homogeneous for j in range(robot.model.njoints)]


def some_points(item, rng, n=60):
    """Points of a body in its joint's frame."""
    cloud = points_in(item.shape, rng, n)
    return moved(cloud[rng.permutation(len(cloud))[: 2 * n]], item.placement)


def assert_bounds_motion(robot, bodies, reach, seed=0, n=30):
    rng = np.random.default_rng(seed)
    points = [some_points(item, rng) for item in bodies]
    for q in random_q(robot, n, seed):
        scale = rng.choice([1e-3, 0.1, 1.0])
        delta = rng.normal(size=robot.dof) * scale * (rng.random(robot.dof) < 0.6)
        delta = np.clip(q + delta, robot.lower, robot.upper) - q  # reach holds within limits
        before, after = placements(robot, q), placements(robot, q + delta)
        limit = reach.motion(delta[None])[0]
        for body, cloud, most in zip(bodies, points, limit, strict=True):
            shift = np.linalg.norm(moved(cloud, after[body.joint]) - moved(cloud, before[body.joint]), axis=1)
            assert shift.max() <= most + SLACK


@pytest.mark.parametrize("name", ROBOTS)
def test_no_point_moves_further(name):
    assert_bounds_motion(load(name), load(name).bodies, Reach.from_robot(load(name)))


def sliding(urdf_file) -> Robot:
    box, rod = geometry_xml(Box((0.2, 0.1, 0.1))), geometry_xml(Cylinder(0.05, 0.4))
    return Robot.load(
        urdf_file(
            link_xml("a", box)
            + link_xml("b", rod, '<origin xyz="0.1 0 0.2" rpy="0.3 0.4 0"/>')
            + link_xml("c", box, '<origin xyz="0 0.2 0"/>')
            + link_xml("d", rod)
            + joint_xml("turn", "a", "b", axis="0.6 0.8 0", limit="-3 3")
            + joint_xml("slide", "b", "c", "prismatic", "0 0 1", xyz="0.3 0 0", limit="-0.5 1.5")
            + joint_xml("end", "c", "d", axis="1 0 0", xyz="0.1 0.1 0", limit="-3 3")
        )
    )


def test_beyond_a_sliding_joint(urdf_file):
    robot = sliding(urdf_file)
    assert_bounds_motion(robot, robot.bodies, Reach.from_robot(robot), n=300)


@pytest.mark.parametrize("name", ["iiwa14", "panda", "planar_2r", "ur5"])
def test_reach_is_close_to_the_motion_of_some_point(name):
    """A bound that is far too large would be safe and useless: some point really comes near it."""
    robot, h = load(name), 1e-4
    reach, rng = Reach.from_robot(robot).bodies, np.random.default_rng(0)
    best = np.zeros_like(reach)
    points = [some_points(item, rng) for item in robot.bodies]
    for q in np.vstack([np.zeros((1, robot.dof)), random_q(robot, 60)]):
        before = placements(robot, q)
        for k, step in enumerate(h * np.eye(robot.dof)):
            after = placements(robot, q + step)
            for b, item in enumerate(robot.bodies):
                shift = moved(points[b], after[item.joint]) - moved(points[b], before[item.joint])
                best[b, k] = max(best[b, k], np.linalg.norm(shift, axis=1).max() / h)
    carried = reach > 1e-6
    assert np.median(best[carried] / reach[carried]) > 0.5


@pytest.mark.parametrize("name", ["iiwa14", "panda", "z1"])
def test_relative_motion_of_two_bodies(name):
    """Seen from one body, no point of the other moves further than the relative reach says."""
    robot = load(name)
    world = checker_of(name).world
    relative = Reach.from_robot(robot).relative(world.self_pairs)
    rng = np.random.default_rng(4)
    for q in random_q(robot, 20, seed=4):
        delta = np.clip(q + rng.normal(size=robot.dof) * 0.2, robot.lower, robot.upper) - q
        before, after = placements(robot, q), placements(robot, q + delta)
        for (i, k), row in zip(world.self_pairs, relative, strict=True):
            first, second = robot.bodies[i], robot.bodies[k]
            cloud, near = some_points(second, rng, 20), some_points(first, rng, 20)
            seen = [
                moved(moved(cloud, where[second.joint]), np.linalg.inv(where[first.joint])) for where in (before, after)
            ]
            # the distance of the pair changes by no more than both of them move against each other
            gaps = [np.linalg.norm(near[:, None] - points[None], axis=2) for points in seen]
            assert np.abs(gaps[1] - gaps[0]).max() <= np.abs(delta) @ row + SLACK
