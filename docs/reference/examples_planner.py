"""An example of each public class of ``planner``; the pages of the reference show them, and a test runs them."""

# --- AxisConstraint ---
import planner

upright = planner.AxisConstraint("z", direction=(0, 0, -1), angle=0.0873)  # the tool points down within 5 degrees
# --- Box ---
import planner

box = planner.Obstacle("box", planner.Box((0.1, 0.1, 0.2)), planner.pose([0.5, 0.3, 0.1]))
# --- BoxConstraint ---
import planner

inside = planner.BoxConstraint(lower=(0.2, -0.5, 0.1), upper=(0.8, 0.5, 0.9))  # m, in the world
# --- Capsule ---
import planner

bar = planner.Obstacle("bar", planner.Capsule(radius=0.02, length=0.5), planner.pose([0.6, 0.2, 0.4]))
# --- Cell ---
import planner

cell = planner.Cell(
    "bench",
    {
        "left": planner.Robot.load("planar_2r"),
        "right": planner.Robot.load("planar_2r", base=planner.pose([1.5, 0, 0], rpy=[0, 0, 3.1416])),
    },
)
plan = planner.plan(cell=cell, start={"left": [0.8, 0.4]}, goal={"left": [-0.8, -0.4]}, nodes=50)
# --- CellPlanner ---
import planner

arms = {
    "left": planner.Robot.load("planar_2r"),
    "right": planner.Robot.load("planar_2r", base=planner.pose([1.5, 0, 0], rpy=[0, 0, 3.1416])),
}
cell_planner = planner.CellPlanner(planner.Cell("bench", arms), nodes=50)
plan = cell_planner.plan({"left": [0.8, 0.4], "right": [0.8, 0.4]}, {"left": [-0.8, -0.4]})
# --- CollisionChecker ---
import planner

robot = planner.Robot.load("panda")
checker = planner.make_checker(robot, planner.Scene.load("shelf"))
checker.first_contact(robot.home)  # None: free
# --- Cylinder ---
import planner

post = planner.Obstacle("post", planner.Cylinder(radius=0.03, length=1.0), planner.pose([0.5, 0, 0.5], rpy=[0, 0, 0]))
# --- DepthImage ---
import numpy as np
import planner

depth = np.full((48, 64), 1.2)  # m along the optical axis
camera = planner.pose([1.5, 0, 1.0], rpy=[0, np.pi, 0])  # x right, y down, z forwards
image = planner.DepthImage(depth, (60.0, 60.0, 32.0, 24.0), camera)
scene = planner.Scene("cell", image.obstacles("camera"))
# --- FollowRequest ---
import planner

request = planner.FollowRequest.from_options(robot="panda", scene="empty", beta=0.2)
line = {"points": [{"position": [0.45, y, 0.4], "axis": [0, 0, -1]} for y in (-0.1, 0.1)]}
plan = planner.follow(line, request=request)
# --- Gate ---
import numpy as np

import planner

gate = planner.Gate("planar_2r", "empty")
verdict = gate.check([[0.0, 0.5], [0.02, 0.52]], times=[0.1, 0.2], state=(np.array([0.0, 0.5]), np.zeros(2)))
# --- Grasp ---
import planner

grasp = planner.Grasp(position=(0, 0, 0.05), axis=(0, 0, -1), opening=0.06)  # the tool in the object's frame
pick = planner.Pick("mug", grasps=(grasp,))
# --- KnownMotion ---
import planner

motion = planner.KnownMotion([0, 4], [planner.pose([1.0, -1.0, 0.2]), planner.pose([1.0, 1.0, 0.2])])  # s, poses
# --- LimitsRequest ---
import planner

gate = planner.Gate("panda", "shelf", limits=planner.LimitsRequest(velocity_scale=0.5, acceleration=3.0))
# --- Mesh ---
import planner

vertices = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]
mesh = planner.Mesh(vertices, triangles=[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])  # closed, so it is solid
# --- MotionLimits ---
import planner

robot = planner.Robot.load("panda")
limits = planner.MotionLimits.from_robot(robot)
limits.velocity  # (7,) rad/s
# --- Move ---
import planner

steps = (planner.Pick("mug"), planner.Move("home"))
# --- MovingObstacle ---
import planner

motion = planner.KnownMotion([0, 4], [planner.pose([1.0, -1.0, 0.2]), planner.pose([1.0, 1.0, 0.2])])
scene = planner.Scene("cart", moving=(planner.MovingObstacle("cart", planner.Box((0.3, 0.3, 0.4)), motion),))
# --- Objective ---
import planner

objective = planner.Objective(beta=0.2, metric="workspace", floor=0.01)  # length of the tool's path; w at least 0.01
plan = planner.plan("planar_2r", "empty", nodes=60, objective=objective)
# --- Obstacle ---
import planner

visitor = planner.Obstacle("visitor", planner.Sphere(0.2), planner.pose([2.0, 0.0, 0.5]), speed_limit=0.25)
# --- OrientationConstraint ---
import planner

level = planner.OrientationConstraint(angle=0.1)  # within 0.1 rad of the orientation at the start
# --- Outcome ---
import planner

plan = planner.plan("planar_2r", "empty", nodes=60)
if plan.outcome is not planner.Outcome.SOLVED:
    print(plan.outcome.value, plan.reason)
# --- Pick ---
import planner

pick = planner.Pick("mug")  # the planner generates grasps
# --- Place ---
import planner

place = planner.Place("mug", on="board", at=((0.35, 0.2), (0.65, 0.5)), samples=10)
# --- Plan ---
import planner

plan = planner.plan("planar_2r", "empty", nodes=60)
plan.outcome, plan.path, plan.trajectory, plan.cost_to_go.x  # Outcome.SOLVED, (k, 2) rad, a Trajectory, (n,)
s, w = plan.w_along_path  # joint motion (rad) and manipulability there
plan.save("out")
# --- PlanRequest ---
import planner

request = planner.PlanRequest.from_options(robot="planar_2r", scene="empty", nodes=60, beta=0.2)
plan = planner.plan(request=request)
# --- PlaneConstraint ---
import planner

above = planner.PlaneConstraint(normal=(0, 0, 1), distance=0.3)  # z at least 0.3 m
# --- PlannerError ---
import planner

try:
    planner.plan("planar_2r", "no such scene")
except planner.PlannerError as error:
    print(error, error.exit_code)
# --- Points ---
import numpy as np
import planner

xyz = np.random.default_rng(0).uniform([0.5, -0.2, 0.2], [0.6, 0.2, 0.4], (500, 3))
cloud = planner.Obstacle("cloud", planner.Points(xyz, radius=0.01), np.eye(4))
# --- PositionConstraint ---
import planner

near = planner.PositionConstraint(0.05, (0.4, 0.2, 0.5), frame="panda_hand")  # within 5 cm of a point
# --- Progress ---
import planner

progress = planner.Progress(report=lambda *stage: print(stage), stop=lambda: False)
plan = planner.plan("planar_2r", "empty", nodes=60, progress=progress)
# --- Reason ---
import planner

plan = planner.plan("planar_2r", "empty", nodes=60)
if plan.reason:  # None for a solved plan
    print(plan.reason.kind, plan.reason.sentence, plan.reason.to_dict())
# --- Roadmap ---
import planner

robot = planner.Robot.load("planar_2r")
checker = planner.make_checker(robot, planner.Scene.load("empty"))
roadmap = planner.build_roadmap(robot, checker, start=[-1.0, 0.8], goal=[1.3, -0.8], nodes=60)
roadmap.nodes, roadmap.edges, roadmap.manipulability  # (n, 2) rad, (m, 2), (n,)
# --- Robot ---
import planner

robot = planner.Robot.load("panda")  # or a URDF
pose = robot.fk(robot.home)  # (4, 4) of the tool
robot.jacobian(robot.home), robot.ik(pose), robot.manipulability(robot.home)
# --- Samples ---
import planner

samples = planner.plan("planar_2r", "empty", nodes=60).trajectory.sample(0.01)
samples.times, samples.positions, samples.velocities  # (n,) s, (n, dof)
# --- Scene ---
import planner

table = {"name": "table", "type": "box", "size": [0.6, 1.2, 0.04], "position": [0.7, 0, 0.2]}
scene = planner.Scene("cell", [table])
shelf = planner.Scene.load("shelf")  # built in; or a file
# --- Session ---
import planner

session = planner.Session("planar_2r", "empty", nodes=60)
session.plan(start=[-1.0, 0.8], goal=[1.3, -0.8])
session.add(planner.Obstacle("box", planner.Box((0.1, 0.04, 0.2)), planner.pose([0.75, 0, 0])))
plan = session.replan()
# --- Sphere ---
import planner

ball = planner.Obstacle("ball", planner.Sphere(radius=0.1), planner.pose([0.3, -0.4, 0.8]))
# --- SweepRequest ---
import planner

request = planner.SweepRequest.from_options(robot="planar_2r", scene="empty", nodes=60)
tradeoff = planner.sweep(request=request)
# --- Task ---
import planner

box = planner.Obstacle("box", planner.Box((0.05, 0.05, 0.1)), planner.pose([0.5, -0.2, 0.05]))
table = planner.Obstacle("table", planner.Box((0.8, 1.4, 0.04)), planner.pose([0.55, 0, -0.02]))
steps = (planner.Pick("box"), planner.Place("box", "table", ((0.4, 0.1), (0.6, 0.3)), samples=5), planner.Move("home"))
task = planner.Task("panda", planner.Scene("desk", (table, box)), steps)
# --- TaskPlan ---
task_plan = planner.task(task, nodes=100)  # the task of planner.Task
task_plan.segments, task_plan.events, task_plan.trajectory
# --- TaskPlanner ---
task_planner = planner.TaskPlanner.from_task(task, nodes=100)  # the task of planner.Task
task_planner.plan(beta=0.2)
# --- TaskRequest ---
request = planner.TaskRequest.from_options(nodes=100, beta=0.2)
task_plan = planner.task(task, request=request)  # the task of planner.Task
# --- TimingRequest ---
import planner

plan = planner.plan("planar_2r", "empty", nodes=60, timing=planner.TimingRequest(velocity_scale=0.2))
# --- ToolGoal ---
import planner

goal = planner.ToolGoal((planner.pose([0.4, 0.4, 0.5]), planner.AxisConstraint("z", (0, 0, -1), 0.1)))
# --- ToolPath ---
import planner

line = {"points": [{"position": [0.45, y, 0.4], "axis": [0, 0, -1]} for y in (-0.1, 0.1)]}
path = planner.read_tool_path(line)
path.positions, path.tube  # (k, 3) m
# --- Tradeoff ---
import planner

tradeoff = planner.sweep("planar_2r", "empty", nodes=60)
for interval in tradeoff.intervals:
    print(interval.betas, interval.w_min, interval.duration)
plan = tradeoff.at(0.2)
# --- Trajectory ---
import planner

motion = planner.plan("planar_2r", "empty", nodes=60).trajectory
motion.duration, motion.at(0.1), motion.at(0.1, 1), motion.proven  # s, (1, dof) rad, rad/s, True
motion.save("trajectory.json")
# --- Verdict ---
import numpy as np

import planner

gate = planner.Gate("planar_2r", "empty")
verdict = gate.check([[0.0, 0.5], [0.02, 0.52]], times=[0.1, 0.2], state=(np.array([0.0, 0.5]), np.zeros(2)))
if verdict:  # verdict.safe
    print(verdict.safe_until, verdict.clearance, verdict.stop)
# --- Voxels ---
import numpy as np
import planner

occupied = np.zeros((4, 4, 4), dtype=bool)
occupied[1:3, :, 0] = True
grid = planner.Obstacle("grid", planner.Voxels(occupied, pitch=0.05, origin=(0.5, 0.0, 0.2)), np.eye(4))
# ---
