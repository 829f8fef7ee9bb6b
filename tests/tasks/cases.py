"""A small task that tests share: a tall mug, three grasps of it, a post, and a board."""

from functools import cache

import numpy as np

from planner.robot.poses import pose
from planner.robot.scene import Scene
from planner.robot.shapes import Box, Cylinder, Obstacle
from planner.tasks.plan import TaskPlanner
from planner.tasks.sampling import tool_at
from planner.tasks.task import Grasp, Move, Pick, Place, Task

TABLE = Obstacle("table", Box((0.9, 1.6, 0.04)), pose((0.55, 0.0, -0.02)))
BOARD = Obstacle("board", Box((0.3, 0.3, 0.02)), pose((0.5, 0.35, 0.21)))
POST = Obstacle("post", Box((0.04, 0.04, 0.45)), pose((0.62, 0.0, 0.225)))
MUG = Obstacle("mug", Cylinder(0.03, 0.24), pose((0.5, -0.3, 0.12)))
SCENE = Scene("small", (TABLE, BOARD, POST, MUG))


def _grasp(position, approach, closing) -> Grasp:
    return Grasp.from_matrix(tool_at(np.array(position), np.array(approach), np.array(closing)), 0.06)


GRASPS = (
    _grasp((0.0, 0.0, 0.1), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
    _grasp((0.0, 0.0, 0.1), (0.0, 0.0, -1.0), (0.6, 0.8, 0.0)),
    _grasp((0.0, 0.0, 0.1), (0.6, 0.0, -0.8), (0.0, 1.0, 0.0)),
)
ON_BOARD = Place("mug", "board", ((0.36, 0.21), (0.64, 0.49)), samples=2)
SMALL = Task("panda", SCENE, (Pick("mug", GRASPS), ON_BOARD, Move("home")))

TINY = Task("planar_2r", Scene("nothing"), (Move("home"),))


@cache
def small() -> TaskPlanner:
    """The task with its network, planned once."""
    return TaskPlanner.from_task(SMALL, nodes=100, ik_solutions=2)
