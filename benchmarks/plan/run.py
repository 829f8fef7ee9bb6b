"""Measures whole plans on a folder of problems, and OMPL's planners on the same: success, paths, motions.

How. Every run has a process of its own. Its budget is the plan's own, in nodes and motions; the time limit only kills a
run that takes too long with its measurements. Times are of the planning itself, without the start of Python but with
the libraries that it loads on its way; they, lengths, w and clearances are medians over the solved runs, "95 %" is the
95th percentile. "Of those tried" leaves out the refused, whose start or goal is out of limits or in collision. "First
path" is when start and goal were first joined by proven edges. Lengths are Euclidean joint motion, and the tool's path;
corners are changes of direction. w is Yoshikawa's manipulability sampled along the whole path, which dips where w falls
below that of both its ends. The gap is that of the cost to a lower bound that holds for every path; below beta 1 most
of the gap is the bound's. Clearance is the smallest distance to anything every centimetre of motion, by the library
that planned. Contacts: segments of paths on which the other collision library finds a contact at a millimetre of
motion. Ratios are medians, over the problems and seeds that both solved.

OMPL's planners check motions in states between which no point moves further than 2 cm, with the library that plans, and
prove nothing; RRT* and BIT* minimise length and stop when their processor time is up, RRTConnect when it has a path,
which OMPL's simplification then shortens.

Motions. A path is timed with shortcuts in time, with rounded corners only, and with a stop at each, all with limits on
jerk. Limits are compared with the exact extrema of the pieces between knots, contacts looked for by the library that
has not planned, at states 0.1 mm of motion apart. toppra (where it is installed) runs along the same curve without
limits on jerk; roboplan (with --python) times the same path by its default spline and TOPP-RA, its share of a limit is
that of its own samples, of which a controller makes cubics.

Limitations. Times depend on the machine; compare them within one run. States every 0.1 mm are no proof.
"""

from __future__ import annotations

import itertools
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from benchmarks import bench
from benchmarks.plan.case import OURS
from benchmarks.plan.report import fault, group, tables
from benchmarks.problems import Problem, find_problems
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.problem.request import LimitsRequest, PlanRequest
from planner.robot.robot import Robot
from planner.trajectory.limits import MotionLimits

_COLUMNS = ("robot", "collision", "nodes", "beta", "widen_limits")
_BY_PROBLEM = ("scene", "request", "seed")


def plan(
    folder: bench.Folder,
    plain: Annotated[PlanRequest, bench.Flat] = PlanRequest.from_options(robot="panda"),  # noqa: B008 (frozen)
    limits: Annotated[LimitsRequest, bench.Flat] = LimitsRequest(),  # noqa: B008 (frozen)
    out: bench.Out = Path("bench-plan"),
    seeds: tuple[int, ...] = (0, 1, 2),
    planners: tuple[Literal["RRTConnect", "RRT*", "BIT*"], ...] = (),
    seconds: float = 5.0,
    python: str | None = None,
    time_limit: float = 120.0,
    workers: bench.Workers = bench.SERIAL,
    debug: bench.Debug = False,
) -> int:
    """A folder of planning problems, each planned with several seeds: success, times, paths, motions, safety.

    A problem is request<X>.yaml, a MoveIt motion plan request, with scene<X>.yaml or scene<X>.scene next to it, in
    FOLDER or in folders inside it, which are the scene types. All options are those of 'planner plan', but for what
    each problem says itself (scene, request, start, goal) and --seed, in whose place --seeds stands. Run again with
    another --beta, --refinement-rounds, --nodes or --collision and the same --out, and the report sets them side by
    side. Paths and motions are checked by the library that has not planned. Writes plan.csv, one row a run, and
    plan.md.

    Args:
        folder: Folder of the problems.
        seeds: Seeds to plan every problem with.
        planners: OMPL's planners to plan every problem with too.
        seconds: Processor time that OMPL's planners get.
        python: Python of an environment of its own with roboplan in it, which times the same paths.
        time_limit: Seconds after which a run is killed and recorded as timed out; the budget is in nodes and motions.
    """
    bench.require_left_to_problems(plain, "seed")
    if not seeds or not time_limit > 0 or not seconds > 0:
        raise OptionError("give at least one seed, and times above 0 s.")
    asked = [plain.with_options(seed=seed) for seed in seeds]  # refuses a seed that is out of range
    problems = find_problems(folder)
    robot = Robot.load(str(plain.what.robot))
    words = MotionLimits.from_robot(robot, limits).text(robot)
    cases = []
    for problem, request, method in itertools.product(problems, asked, (OURS, *planners)):
        row = _blank(problem, request, method, limits, f"{seconds:g} s", words, time_limit)
        options = {"method": method, "seconds": seconds, "python": python}
        options |= {"request": problem.asked(request).config(), "limits": bench.plain_limits(limits)}
        cases.append(bench.Case((row,), options))
    return bench.run_bench(BENCH, out, cases, partial(_measure, time_limit=time_limit), workers)


def _measure(options: dict[str, Any], progress: Progress, time_limit: float) -> Any:
    return bench.measure_apart("benchmarks.plan.case", options, progress, time_limit, seconds="process_s")


def _blank(
    problem: Problem,
    request: PlanRequest,
    method: str,
    limits: LimitsRequest,
    seconds: str,
    words: str,
    time_limit: float,
) -> bench.Row:
    """The row before anything is measured; options that OMPL's planners do not have are at zero."""
    default, taken, ours = PlanRequest().config(), {*_COLUMNS, *_BY_PROBLEM}, method == OURS
    more = {k: v for k, v in request.config().items() if k not in taken and v != default[k]}
    more |= {k: v for k, v in vars(limits).items() if v is not None}
    return bench.Row(
        problem=problem.name,
        kind=problem.kind,
        method=method,
        seed=request.quality.seed,
        robot=str(request.what.robot),
        collision=request.what.collision,
        nodes_asked=request.quality.nodes if ours else 0,
        beta=request.quality.beta if ours else 1.0,
        widen_limits=request.what.widen_limits,
        options=", ".join(f"{name} {value}" for name, value in more.items()) if ours else seconds,
        limits=words,
        time_limit_s=time_limit,
        content=problem.content(request),
        software=bench.software(),
    )


BENCH = bench.Bench("plan", __doc__, tables, fault=fault, group=group)
