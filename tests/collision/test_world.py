"""The numbering of pairs of bodies and obstacles."""

import numpy as np

from planner.collision.world import World
from planner.kinematics.forward import Chain, joint_placements
from planner.problem.conditions import PlaneConstraint
from planner.robot.poses import pose
from planner.robot.robot import with_carried
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Obstacle, Sphere
from tests.worlds import load, random_q

ROBOT = load("planar_2r")
SCENE = Scene(
    "made",
    (Obstacle("a", Sphere(0.1), pose([1, 0, 0])), Obstacle("b", Sphere(0.1), pose([0, 1, 0]))),
    allowed=frozenset([frozenset((ROBOT.bodies[0].link, "b"))]),
)


def test_every_pair_has_a_number_and_its_members() -> None:
    world = World.from_scene(ROBOT, SCENE, frozenset())
    bodies, obstacles = len(world.bodies), len(world.obstacles)
    count = bodies * obstacles + len(world.self_pairs)
    assert world.pair_reach.shape == (count, ROBOT.dof)
    assert [world.members(pair) for pair in range(bodies * obstacles)] == list(np.ndindex(bodies, obstacles))
    for pair in range(bodies * obstacles, count):
        first, second = world.members(pair)
        assert not world.is_scene_pair(pair)
        assert world.bodies[first].joint != world.bodies[second].joint
    assert str(world.contact(1)) == f"'{world.bodies[0].link}' and 'b'"
    assert world.checked.tolist()[0] == [True, False]


def test_another_scene_and_a_carried_object_leave_the_rest_of_a_world_unchanged() -> None:
    robot = load("panda")
    assert robot.disabled_pairs
    ball = Carried("panda_hand", "ball", Sphere(0.02), pose([0, 0, 0.1]), ("panda_link5",))
    held = with_carried(robot, [ball])
    world = World.from_scene(
        robot, Scene("made", SCENE.obstacles), robot.disabled_pairs, 0.01, (PlaneConstraint((0, 0, 1), 0.0),)
    )
    other = world.among(Scene("other"), held)
    pairs = {frozenset((held.bodies[i].link, held.bodies[k].link)) for i, k in other.self_pairs}
    assert not pairs & (robot.disabled_pairs | held.touching)
    assert frozenset(("ball", "panda_link0")) in pairs
    assert (other.obstacles, other.margin, other.conditions) == ((), 0.01, world.conditions)
    back = other.among(world.scene, robot)
    np.testing.assert_array_equal(back.self_pairs, world.self_pairs)
    np.testing.assert_array_equal(back.checked, world.checked)


def test_no_motion_changes_a_distance_by_more_than_the_reach_says() -> None:
    """Of the centres of bodies, which are points of them."""
    world = World.from_scene(ROBOT, SCENE, frozenset())
    chain = Chain.from_arm(ROBOT)

    def centres(q: np.ndarray) -> np.ndarray:
        rotation, position = joint_placements(chain, q[None])
        return np.array(
            [rotation[body.joint, 0] @ body.placement[:3, 3] + position[body.joint, 0] for body in world.bodies]
        )

    for a, b in zip(random_q(ROBOT, 20), random_q(ROBOT, 20, seed=1), strict=True):
        before, after = centres(a), centres(b)
        most = world.pair_reach @ np.abs(b - a)
        for pair in range(len(most)):
            first, second = world.members(pair)
            if world.is_scene_pair(pair):
                other = [world.obstacles[second].placement[:3, 3]] * 2
            else:
                other = [before[second], after[second]]
            change = np.linalg.norm(after[first] - other[1]) - np.linalg.norm(before[first] - other[0])
            assert abs(change) <= most[pair] + 1e-12
