"""The two learning rules: the paper's Hebbian one as printed, and the error-driven reading of it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import AssumptionError, OptionError


@dataclass(frozen=True)
class LearningRule(ABC):
    """How one training iteration moves the weights wbar_ij of eq. (wb), each by what its two ends know.

    ``alpha`` is the learning rate, ``beta`` > 0 weighs the distance in the reward 1 - beta d_ij. Raises OptionError
    unless both are positive and finite.
    """

    alpha: float
    beta: float
    name: ClassVar[str]

    def __post_init__(self) -> None:
        for name, value in (("alpha", self.alpha), ("beta", self.beta)):
            if not (math.isfinite(value) and value > 0.0):
                raise OptionError(f"the learning rule's {name} must be a positive number, not {value}.")

    @property
    @abstractmethod
    def label(self) -> str:
        """Name and parameters."""

    @abstractmethod
    def updated(self, wbar: Floats, activity_i: Floats, activity_j: Floats, d: Floats) -> Floats:
        """The weights (k,) in (0, 1) after one iteration, from the activities 1 - x at both ends and the distances d.

        All arrays are (k,), one entry per arc.
        """


@dataclass(frozen=True)
class Hebbian(LearningRule):
    """Delta wbar_ij = alpha (1 - x_i)(1 - x_j) R with R = 1 - beta d_ij: the paper's rule, as printed.

    Nothing in it ends the growth: R is positive for every d < 1 / beta, so weights only rise, and without ``floor``
    and ``ceiling``, at which they are held here, they leave (0, 1) and eq. (wb) is no longer progressive. A larger
    ``alpha`` brings them to the ceiling sooner, a ``beta`` above 1 / d drives long arcs to the floor. For weights that
    approach 1 - w_ij / K use :class:`ErrorDriven`.
    """

    alpha: float = 0.2
    beta: float = 3.0
    floor: float = 0.01
    ceiling: float = 0.99
    name: ClassVar[str] = "hebbian"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.floor < self.ceiling < 1.0:
            raise OptionError(
                f"floor {self.floor} and ceiling {self.ceiling} must satisfy 0 < floor < ceiling < 1, eq. (wb)."
            )

    @property
    def label(self) -> str:
        return f"Hebbian, alpha = {self.alpha:g}, beta = {self.beta:g}"

    def updated(self, wbar: Floats, activity_i: Floats, activity_j: Floats, d: Floats) -> Floats:
        """See :class:`LearningRule`."""
        # In (0, 1) by construction: [floor, ceiling] lies inside, and fmin and fmax end there whatever the change is.
        return np.clip(self.unbounded(wbar, activity_i, activity_j, d), self.floor, self.ceiling)

    def unbounded(self, wbar: Floats, activity_i: Floats, activity_j: Floats, d: Floats) -> Floats:
        """The rule to the letter, which may leave (0, 1)."""
        return wbar + self.alpha * activity_i * activity_j * (1.0 - self.beta * d)


@dataclass(frozen=True)
class ErrorDriven(LearningRule):
    """Delta wbar_ij = g (1 - beta d_ij - wbar_ij), g = min(1, alpha (1 - x_i)(1 - x_j)).

    The rule has three factors, of which the third is an error: the weight predicts the reward 1 - beta d_ij of the
    paper's rule. This is the rule of the article that the paper takes its own from (Kusmierz, Isomura, Toyoizumi:
    Learning with three factors: modulating Hebbian plasticity with errors, 2017). Its fixed point is the 1 - w_ij / K
    that the paper says the weights approximate, with K = 1 / beta. A smaller ``beta`` tells paths of more equal length
    apart (:func:`planner.learning.sufficient_K`); a larger ``alpha`` learns further from the source per iteration.

    Raises AssumptionError where beta d_ij is not in (0, 1): such an arc has no weight that eq. (wb) allows.
    """

    alpha: float = 5.0
    beta: float = 1e-3
    name: ClassVar[str] = "error_driven"

    @property
    def label(self) -> str:
        return f"error-driven, alpha = {self.alpha:g}, beta = {self.beta:g}"

    def updated(self, wbar: Floats, activity_i: Floats, activity_j: Floats, d: Floats) -> Floats:
        """See :class:`LearningRule`."""
        target = self.target(d)
        gain = np.clip(self.alpha * activity_i * activity_j, 0.0, 1.0)
        moved = wbar + gain * (target - wbar)
        # In (0, 1): with 0 <= gain <= 1 the result is a mean of wbar and target, and both lie there. Rounding can carry
        # it past the nearer end by one unit in the last place, to 1.0 at worst, so it is held between the two.
        return np.clip(moved, np.minimum(wbar, target), np.maximum(wbar, target))

    def target(self, d: Floats) -> Floats:
        """1 - beta d_ij (k,), where the weights come to rest."""
        target = 1.0 - self.beta * np.asarray(d, dtype=np.float64)
        bad = np.flatnonzero(~((target > 0.0) & (target < 1.0)))
        if bad.size:
            raise AssumptionError(
                f"an arc of length {d[bad[0]]:g} has the reward {target[bad[0]]:g} where eq. (wb) needs a weight in "
                f"(0, 1): choose beta below 1 / (longest distance), and distances above {1e-16 / self.beta:.1g}"
            )
        return target
