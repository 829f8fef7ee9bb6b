"""What the manipulator study is asked for in tests: small roadmaps."""

from planner.problem.request import SweepRequest

SMALL = SweepRequest(nodes=80, collision="coal", seed=1)
