"""Learning on a robot's roadmap: what its edges cost is not known until a path has come past them; and its verdicts."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np

from planner import gabf, learning
from planner.base.arrays import Floats
from planner.base.errors import OptionError, StateError
from planner.base.progress import QUIET, Progress
from planner.construction.build import build_roadmap
from planner.kinematics.forward import tool_positions
from planner.learning import ErrorDriven, Execution
from planner.learning.executions import believed, policy_cost, run_executions
from planner.learning.roadmap_costs import SlowZone, edge_of_arc, execution_costs, greatest_costs, least_costs
from planner.paths.measure import dense_path
from planner.planning.network import build_network, distance_cost
from planner.problem.objective import Objective
from planner.problem.request import SERIAL, RoadmapRequest, WorkersRequest
from planner.processes.parallel import collected
from planner.reproduce.report import Row, Verdict, spread, tally
from planner.roadmap.roadmap import Roadmap, path_waypoints
from planner.setup.open import Query, make_query

DENSITY = 6.0
"""Edges per node. At the paper's two there is so little to choose that learning ends after two or three executions."""

BETA = 0.1
"""Share of plain motion in what an edge costs; the rest is manipulability."""

ZONE_RADIUS, ZONE_FACTOR = 0.25, 4.0
"""The slow zone, m, around the tool half-way along the shortest path, and the factor on the cost of motion in it."""

LOSS = 1e-3
"""K is chosen so that the path of eq. (wb) costs at most 0.1 % more than the cheapest one: K_for_excess."""

_SHOWN = (1, 3, 10, 50)

PRIORS = ("optimistic", "average", "pessimistic")
"""The believed cost of an edge before it is seen.

It is the edge's least cost, the roadmap's mean cost per rad times its length (which takes experience that the planner
does not have), or its greatest cost."""

TASKS = ("one start", "many starts")
"""Every execution from the scene's start, or each from another node drawn at random."""


@dataclass(frozen=True)
class RobotSettings:
    """Which robot, where, on how many roadmaps of how many nodes, and how many executions on each."""

    robot: str
    scene: str = "paper"
    start: str = "start"
    goal: str = "goal"
    roadmaps: int = 8
    nodes: int = 300
    executions: int = 200

    def __post_init__(self) -> None:
        for name, least in (("roadmaps", 1), ("executions", 1), ("nodes", 20)):
            if getattr(self, name) < least:
                raise OptionError(f"{name} must be at least {least}, not {getattr(self, name)}.")


@dataclass(frozen=True)
class Step:
    """One execution in numbers, all relative to the informed optimum of its start.

    ``regret``: the executed path's cost over the optimum, less 1; ``estimate``: the cost the planner believed, over the
    optimum; ``field_regret``: the mean over all nodes of the regret that following the field from there would have;
    ``known``: the share of edges seen so far, this execution included; ``settled``: GABF settled before T_p.
    """

    regret: float
    estimate: float
    field_regret: float
    known: float
    settled: bool


@dataclass(frozen=True)
class Campaign:
    """All executions on one roadmap with one prior and one kind of task."""

    roadmap: int
    prior: str
    task: str
    steps: tuple[Step, ...]
    costly: int
    allowed: int
    """Executions that exceed the optimum by more than K leaves open, and how many the optimistic bound allows."""

    @property
    def last_regret(self) -> float:
        return self.steps[-1].regret


@dataclass(frozen=True, eq=False)
class RobotCase:
    """One roadmap with its true costs. Arrays over the arcs of ``network``: lengths, true costs, prior beliefs."""

    number: int
    roadmap: Roadmap
    network: gabf.Network
    costs: Floats
    priors: dict[str, Floats]
    rule: ErrorDriven
    optimum: Floats

    @property
    def start(self) -> int:
        """The start from which the goal is reached at least cost."""
        starts = self.roadmap.starts
        return int(starts[np.argmin(self.optimum[starts])])


def run_campaigns(
    settings: RobotSettings,
    seed: int = 0,
    progress: Progress = QUIET,
    workers: WorkersRequest = SERIAL,
) -> list[Campaign]:
    """Every prior and task on every roadmap; whole roadmaps only, where it is stopped early.

    Raises :class:`PlannerError` for an unusable robot, scene or state, StateError among them where a roadmap came out
    without a path from start to goal.
    """
    _query(settings)  # refuses what cannot be used before anything is begun
    on_roadmap = partial(_all_campaigns, settings=settings, seed=seed)
    done = collected(range(settings.roadmaps), on_roadmap, workers, "roadmaps", progress)
    return [campaign for campaigns in done for campaign in campaigns]


@lru_cache(1)
def _query(settings: RobotSettings) -> Query:
    request = RoadmapRequest(settings.robot, settings.scene, start=settings.start, goal=settings.goal)
    return make_query(request, near_start=False)


def _all_campaigns(number: int, progress: Progress, settings: RobotSettings, seed: int) -> list[Campaign] | None:
    """Every prior and task on one roadmap; None where stopped."""
    case = make_case(_query(settings), settings.nodes, seed, number, progress)
    if case is None:
        return None
    kinds = itertools.product(TASKS, PRIORS)
    found = [campaign(case, prior, task, settings.executions, seed) for task, prior in kinds if not progress.stopped]
    return None if progress.stopped else found


def campaigns_in(settings: RobotSettings | None) -> int:
    """How many campaigns a whole run has."""
    return settings.roadmaps * len(TASKS) * len(PRIORS) if settings else 0


def make_case(query: Query, nodes: int, seed: int, number: int, progress: Progress = QUIET) -> RobotCase | None:
    """Grow roadmap ``number`` of a seed and measure what its edges cost; None where it was interrupted."""
    own = int(np.random.default_rng([seed, number]).integers(2**31))
    ends = query.starts, query.goals
    roadmap = build_roadmap(query.robot, query.checker, *ends, nodes, own, progress, density=DENSITY)
    if progress.stopped:
        return None
    if not roadmap.connected:
        raise StateError(f"roadmap {number} joins no start to a goal within {nodes} nodes: raise --nodes.")
    plain = build_network(roadmap, Objective(1.0, charge="nodes"))
    zone = slow_zone(query, roadmap, plain)
    edge, length = edge_of_arc(roadmap, plain), distance_cost(roadmap)
    costs, greatest = execution_costs(query.robot, roadmap, BETA, [zone]), greatest_costs(roadmap, [zone])
    rule = ErrorDriven(beta=1.0 / learning.K_for_excess(float(greatest.max()), LOSS))
    priors = (least_costs(roadmap, BETA), costs.sum() / length.sum() * length, greatest)
    informed = gabf.Network(plain.indptr, plain.indices, costs[edge], sources=roadmap.goals, kernel=gabf.Additive())
    return RobotCase(
        number=number,
        roadmap=roadmap,
        network=plain,
        costs=costs[edge],
        priors={name: prior[edge] for name, prior in zip(PRIORS, priors, strict=True)},
        rule=rule,
        optimum=gabf.oracle(informed),
    )


def slow_zone(query: Query, roadmap: Roadmap, network: gabf.Network) -> SlowZone:
    """A zone that the planner is not told of, in the middle of where it would go if it minimized only path length."""
    field = gabf.oracle(network)
    start = int(roadmap.starts[np.argmin(field[roadmap.starts])])
    path = dense_path(path_waypoints(roadmap, query.robot, gabf.extract_path(network, field, start)))
    middle = tool_positions(query.robot, path[len(path) // 2][None])[0]
    return SlowZone(middle, ZONE_RADIUS, ZONE_FACTOR)


def campaign(case: RobotCase, prior: str, task: str, executions: int, seed: int) -> Campaign:
    """Execute, reveal, learn, plan again."""
    beliefs = believed(case.network, case.rule, case.priors[prior])
    elsewhere = np.setdiff1d(np.flatnonzero(np.isfinite(case.optimum)), case.roadmap.goals)
    drawn = np.random.default_rng([seed, case.number, 1]).choice(elsewhere, executions)
    starts = np.full(executions, case.start) if task == TASKS[0] else drawn
    known = np.zeros(case.network.n_arcs, dtype=bool)
    steps, costly = [], 0
    for done in run_executions(beliefs, case.costs, case.rule, starts):
        known[done.seen] = True
        steps.append(_step(case, done, float(known.mean())))
        costly += int(steps[-1].regret > LOSS)
    return Campaign(case.number, prior, task, tuple(steps), costly, case.network.n_nodes // 2)


def _step(case: RobotCase, done: Execution, known: float) -> Step:
    start, x = int(done.path[0]), done.stage.field.x
    law = done.stage.field.law
    settled = done.stage.field.settling_time
    rooms = np.isfinite(case.optimum) & (case.optimum > 0.0)
    field_regret = policy_cost(done.stage, case.costs)[rooms] / case.optimum[rooms] - 1.0
    return Step(
        regret=done.cost / case.optimum[start] - 1.0,
        estimate=float(-np.log1p(-x[start]) / case.rule.beta / case.optimum[start]),
        field_regret=float(field_regret.mean()),
        known=known,
        settled=settled is not None and (law.prescribed_time is None or settled < law.prescribed_time),
    )


def robot_rows(campaigns: Sequence[Campaign], settings: Mapping[str, Any] | None) -> list[Row]:
    """One line a task, prior and a few of the executions; columns as :func:`learning.learning_table`."""
    rows: list[Row] = []
    if not campaigns or settings is None:
        return rows
    for task, prior in itertools.product(TASKS, PRIORS):
        regret = regrets(campaigns, task, prior)
        about = f"{settings['robot']} in {settings['scene']}, {task}, {prior}"
        for k in sorted({*(k for k in _SHOWN if k < regret.shape[1]), regret.shape[1]}):
            now = regret[:, k - 1]
            excess = (round(100.0 * float(value), 6) for value in (now.mean(), now.max()))  # no rounding of sums
            rows.append(learning_row(about, k, (now <= LOSS).mean(), *excess))
    return rows


def learning_row(study: str, iteration: int, optimal: Any, mean: Any, largest: float) -> Row:
    """One line of the table: the share of optimal paths, and by how much (%) they are too costly."""
    excess = {"mean excess (%)": float(mean), "largest excess (%)": largest}
    return {"study": study, "iteration": iteration, "optimal": float(optimal), **excess}


def campaign_records(campaigns: Sequence[Campaign]) -> list[Row]:
    """Every campaign, each quantity of its executions as a list."""
    return [
        {
            **{name: value for name, value in vars(campaign).items() if name != "steps"},
            **{name: [getattr(step, name) for step in campaign.steps] for name in vars(campaign.steps[0])},
        }
        for campaign in campaigns
    ]


def regrets(campaigns: Sequence[Campaign], task: str, prior: str, quantity: str = "regret") -> np.ndarray:
    """(roadmaps, executions) of one prior and task."""
    return np.array([[getattr(s, quantity) for s in c.steps] for c in _of(campaigns, task, prior)])


def robot_verdicts(campaigns: Sequence[Campaign]) -> tuple[Verdict, ...]:
    """What the executions show; counts are of roadmaps. The paper says nothing of this, so all are marked (ours)."""
    if not campaigns:
        return ()
    (one, many), optimistic = TASKS, PRIORS[0]
    fields = {prior: regrets(campaigns, many, prior, "field_regret").mean(axis=0) for prior in PRIORS}
    return (
        *(_ends_optimal(campaigns, one, prior) for prior in PRIORS),
        tally(
            "(ours) Optimism is bounded: at most n / 2 executions cost more than the optimum, whatever the starts.",
            (c.costly <= c.allowed for c in campaigns if c.prior == optimistic),
            "; ".join(f"{task}: {spread(c.costly for c in _of(campaigns, task, optimistic))}" for task in TASKS)
            + f" of {spread(c.allowed for c in campaigns)} allowed",
        ),
        tally(
            "(ours) The learned field approaches the informed optimum (optimistic, many starts).",
            # the paths from every node have lost nine tenths of the regret they had at worst
            (field[-1] <= 0.1 * max(field) for field in regrets(campaigns, many, optimistic, "field_regret")),
            "mean regret of the paths from every node, first, at its worst and last: "
            + "; ".join(f"{prior} {x[0]:.3f}, {x.max():.3f}, {x[-1]:.3f}" for prior, x in fields.items()),
        ),
        tally(
            "(ours) Every planning stage on the roadmap settles before T_p.",
            (all(step.settled for step in c.steps) for c in campaigns),
            f"{sum(len(c.steps) for c in campaigns)} executions, warm from the x before",
        ),
    )


def _ends_optimal(campaigns: Sequence[Campaign], task: str, prior: str) -> Verdict:
    chosen = _of(campaigns, task, prior)
    stuck = [c.last_regret for c in chosen if c.last_regret > LOSS]
    return tally(
        f"(ours) Learning costs by paying them ends at the informed optimum ({task}, {prior} about unseen edges).",
        (c.last_regret <= LOSS for c in chosen),
        (f"{len(stuck)} stay {spread(100.0 * r for r in stuck)} % costlier; " if stuck else "")
        + f"executions costlier than the optimum "
        f"{spread(c.costly for c in chosen)} of {len(chosen[0].steps)}; sum of regrets "
        f"{spread(sum(s.regret for s in c.steps) for c in chosen)} optimal costs; edges seen at the end "
        f"{spread(100.0 * c.steps[-1].known for c in chosen)} %",
    )


def _of(campaigns: Sequence[Campaign], task: str, prior: str) -> list[Campaign]:
    return [c for c in campaigns if c.task == task and c.prior == prior]
