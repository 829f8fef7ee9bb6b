"""The executions on a robot's roadmaps as rows of a table and as verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from planner.reproduce.learning.robot import LOSS, PRIORS, TASKS, Campaign
from planner.reproduce.report import Row, Verdict, spread, tally

_SHOWN = (1, 3, 10, 50)


def robot_rows(campaigns: Sequence[Campaign], settings: Mapping[str, Any] | None) -> list[Row]:
    """One line a task, prior and a few of the executions; columns as :func:`learning.learning_table`."""
    rows = []
    if not campaigns or settings is None:
        return rows
    for task in TASKS:
        for prior in PRIORS:
            regret = regrets(campaigns, task, prior)
            for k in sorted({*(k for k in _SHOWN if k < regret.shape[1]), regret.shape[1]}):
                rows.append(
                    {
                        "study": f"{settings['robot']} in {settings['scene']}, {task}, {prior}",
                        "iteration": k,
                        "optimal": float((regret[:, k - 1] <= LOSS).mean()),
                        "mean excess (%)": _percent(regret[:, k - 1].mean()),
                        "largest excess (%)": _percent(regret[:, k - 1].max()),
                    }
                )
    return rows


def _percent(regret: float) -> float:
    """Without the rounding of sums."""
    return round(100.0 * float(regret), 6)


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
    one, many = TASKS
    optimistic = PRIORS[0]
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
            (_approaches(campaign) for campaign in _of(campaigns, many, optimistic)),
            "mean regret of the paths from every node, first, at its worst and last: "
            + "; ".join(f"{prior} {_field(campaigns, prior)}" for prior in PRIORS),
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


def _approaches(campaign: Campaign) -> bool:
    """The paths from every node have lost nine tenths of the regret they had at worst."""
    regret = [step.field_regret for step in campaign.steps]
    return regret[-1] <= 0.1 * max(regret)


def _field(campaigns: Sequence[Campaign], prior: str) -> str:
    mean = regrets(campaigns, TASKS[1], prior, "field_regret").mean(axis=0)
    return f"{mean[0]:.3f}, {mean.max():.3f}, {mean[-1]:.3f}"


def _of(campaigns: Sequence[Campaign], task: str, prior: str) -> list[Campaign]:
    return [c for c in campaigns if c.task == task and c.prior == prior]
