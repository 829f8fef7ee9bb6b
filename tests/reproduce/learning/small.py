"""A robot's part of the learning study, small."""

from planner.reproduce.learning.robot import RobotSettings

ROBOT = RobotSettings("planar_2r", "empty", "q:0.5,0.5", "q:-2,1", roadmaps=1, nodes=40, executions=25)
