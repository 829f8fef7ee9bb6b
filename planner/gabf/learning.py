"""Learning-based path planning, section 4.3: GABF settles x, then x trains the weights.

>>> ways = np.array([[1, 0], [2, 1], [2, 3], [3, 0]])  # two ways from 2 to 0, by 1 and by 3
>>> network = gabf.learning.make_untrained_network(*ways.T, sources=[0], n_nodes=4)
>>> rule, distances = gabf.learning.ErrorDriven(beta=0.1), np.array([2.0, 2.0, 1.0, 1.0])
>>> gabf.learning.learn(network, rule, distances, iterations=6)[-1].path(2)
array([2, 3, 0])
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import AssumptionError, OptionError
from planner.gabf.kernels import Multiplicative
from planner.gabf.laws import Law
from planner.gabf.network import Network
from planner.gabf.path import extract_path
from planner.gabf.solve import CostToGo, solve

FIRST_WEIGHT = 0.5  # the paper's initial value of every wbar_ij
FIRST_STATE = 0.0  # x_i(0) of the first planning stage: below every x_i*, so it needs no knowledge of the graph


@dataclass(frozen=True)
class LearningRule(ABC):
    """The change of the weights wbar_ij of eq. (wb) per training iteration, by quantities at both ends.

    ``alpha`` is the learning rate, ``beta`` weighs the distance in the reward 1 - beta d_ij. Raises OptionError unless
    both are positive and finite.
    """

    alpha: float
    beta: float
    name: ClassVar[str]
    title: ClassVar[str]

    def __post_init__(self) -> None:
        for name, value in (("alpha", self.alpha), ("beta", self.beta)):
            if not (math.isfinite(value) and value > 0.0):
                raise OptionError(f"{name} of a learning rule must be a positive number, got {value}.")

    @property
    def label(self) -> str:
        """Name and parameters."""
        return f"{self.title}, alpha = {self.alpha:g}, beta = {self.beta:g}"

    @abstractmethod
    def update(self, wbar: Floats, activity_i: Floats, activity_j: Floats, d: Floats) -> Floats:
        """Return the weights (k,) in (0, 1) after one iteration, one entry per arc.

        ``activity_i`` and ``activity_j`` (k,) are 1 - x at both ends, ``d`` (k,) the distances.
        """


@dataclass(frozen=True)
class Hebbian(LearningRule):
    """Delta wbar_ij = alpha (1 - x_i)(1 - x_j) R with R = 1 - beta d_ij: the paper's rule, as printed.

    R is positive for every d < 1 / beta, so weights only grow. ``floor`` and ``ceiling`` bound them here: else they
    leave (0, 1), and eq. (wb) is no longer progressive. A larger ``alpha`` brings them to the ceiling sooner, a
    ``beta`` above 1 / d drives long arcs to the floor. For weights that approach 1 - w_ij / K use :class:`ErrorDriven`.
    """

    alpha: float = 0.2
    beta: float = 3.0
    floor: float = 0.01
    ceiling: float = 0.99
    name: ClassVar[str] = "hebbian"
    title: ClassVar[str] = "Hebbian"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.floor < self.ceiling < 1.0:
            raise OptionError(f"floor and ceiling must be 0 < floor < ceiling < 1, got {self.floor, self.ceiling}.")

    def update(self, wbar: Floats, activity_i: Floats, activity_j: Floats, d: Floats) -> Floats:
        return np.clip(self.update_without_bounds(wbar, activity_i, activity_j, d), self.floor, self.ceiling)

    def update_without_bounds(self, wbar: Floats, activity_i: Floats, activity_j: Floats, d: Floats) -> Floats:
        """Return the weights (k,) by the printed rule alone, which may leave (0, 1)."""
        return wbar + self.alpha * activity_i * activity_j * (1.0 - self.beta * d)


@dataclass(frozen=True)
class ErrorDriven(LearningRule):
    """Delta wbar_ij = g (1 - beta d_ij - wbar_ij), g = min(1, alpha (1 - x_i)(1 - x_j)).

    The third factor is an error: the weight predicts the reward 1 - beta d_ij of the paper's rule. The paper takes its
    rule from an article that has this one (Kusmierz, Isomura, Toyoizumi: Learning with three factors: modulating
    Hebbian plasticity with errors, 2017). Its fixed point is the 1 - w_ij / K that the weights approximate according to
    the paper, with K = 1 / beta. A smaller ``beta`` distinguishes paths of more equal length; a larger ``alpha`` learns
    further from the source per iteration.

    Raises AssumptionError where beta d_ij is not in (0, 1): eq. (wb) allows no weight for such an arc.
    """

    alpha: float = 5.0
    beta: float = 1e-3
    name: ClassVar[str] = "error_driven"
    title: ClassVar[str] = "error-driven"

    def update(self, wbar: Floats, activity_i: Floats, activity_j: Floats, d: Floats) -> Floats:
        target = self.target(d)
        moved = wbar + np.clip(self.alpha * activity_i * activity_j, 0.0, 1.0) * (target - wbar)
        # rounding can carry the mean of wbar and target past the nearer one, even to 1.0
        return np.clip(moved, np.minimum(wbar, target), np.maximum(wbar, target))

    def target(self, d: Floats) -> Floats:
        """Return 1 - beta d_ij (k,), the fixed point of the weights."""
        target = 1.0 - self.beta * np.asarray(d, dtype=np.float64)
        bad = np.flatnonzero(~((target > 0.0) & (target < 1.0)))
        if bad.size:
            raise AssumptionError(
                f"1 - beta d must be between 0 and 1, eq. (wb), got {target[bad[0]]:g} for an arc of length "
                f"{d[bad[0]]:g}: choose beta below 1 / (longest distance), and distances above {1e-16 / self.beta:.1g}."
            )
        return target


@dataclass(frozen=True, eq=False)
class Stage:
    """A planning stage: the network with the weights wbar_ij, and the field that GABF settled on them.

    ``iteration`` counts the training iterations before it. Where every weight is in (0, 1), as after each learning
    rule, eq. (wb) is progressive on the states of a run: x stays in [x_low, x_high] with x_high < 1, because f(a) = 1 -
    (1 - a) wbar < 1 for a < 1, and there f(a) - a = (1 - a)(1 - wbar) >= (1 - x_high)(1 - max wbar) > 0.
    ``field.premises`` holds these numbers.
    """

    iteration: int
    network: Network
    field: CostToGo

    @property
    def wbar(self) -> Floats:
        """(n_arcs,) the weights."""
        return self.network.weight

    @property
    def activity(self) -> Floats:
        """(n,) 1 - x_i: the largest product of weights along a path to a source; 0 without a path."""
        return np.where(np.isfinite(self.field.x), 1.0 - self.field.x, 0.0)

    def path(self, start: int) -> Ints:
        """Return the nodes from ``start`` to a source along minimising neighbours."""
        return extract_path(self.network, self.field, start)


def make_untrained_network(
    tails: Ints, heads: Ints, sources: Ints, n_nodes: int, wbar: float = FIRST_WEIGHT
) -> Network:
    """Return the network of eq. (wb) before learning, of arcs (tails[k], heads[k]) of weight ``wbar``.

    0 < ``wbar`` < 1. On paths of more than 50 arcs of weight 0.5 x rounds to 1 and a planning stage raises
    AssumptionError: begin with weights nearer to 1 there.
    """
    return Network.from_arcs(tails, heads, np.full(len(heads), wbar), sources, n_nodes, kernel=Multiplicative())


def planning_stage(
    network: Network, x0: Floats | float = FIRST_STATE, law: Law | str | None = None, iteration: int = 0
) -> Stage:
    """Settle x by GABF from ``x0``, under the singularity-free law unless another is given."""
    return Stage(iteration, network, solve(network, law=law, x0=x0))


def learn(
    network: Network, rule: LearningRule, d: Floats, iterations: int, law: Law | str | None = None
) -> tuple[Stage, ...]:
    """Return the ``iterations`` + 1 planning stages before and after each training iteration.

    ``d`` (n_arcs,) are distances. Each iteration trains all arcs at once by the activities at their two ends, and x
    settles from its last states.
    """
    stages = [planning_stage(network, law=law)]
    for k in range(1, iterations + 1):
        activity = stages[-1].activity
        weight = rule.update(network.weight, activity[network.tails], activity[network.indices], d)
        network = replace(network, weight=weight)
        stages.append(planning_stage(network, stages[-1].field.x, stages[-1].field.law, k))
    return tuple(stages)
