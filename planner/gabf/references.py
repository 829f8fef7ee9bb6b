"""Textbook solvers of the same equation, to compare with: SciPy's RK45 and the backward Euler method."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import AssumptionError, OptionError
from planner.gabf.flows import Flow
from planner.gabf.laws import Law, control_input
from planner.gabf.network import Network
from planner.gabf.problem import Problem, reduce
from planner.gabf.solvers import Solver, State, Targets


@dataclass(frozen=True)
class RungeKutta45(Solver):
    """SciPy's explicit RK45 in tau: the paper's ode45, remark (implementation).

    Its right side is not Lipschitz at xhat = 0 under the fixed-time laws, where it chatters at about the size
    of ``rtol``: bound the run by ``until_tau`` or a loose ``settle_tolerance``. A smaller ``rtol`` takes more
    steps.
    """

    rtol: float = 1e-6
    atol: float = 1e-9
    max_step: float = np.inf
    order: ClassVar[int] = 5
    exact_rest: ClassVar[bool] = False
    name: ClassVar[str] = "rk45"

    def __post_init__(self) -> None:
        if not (self.rtol > 0 and self.atol > 0 and self.max_step > 0):
            raise OptionError("rtol, atol and max_step of the RK45 solver must be positive")

    def states(self, problem: Problem, flow: Flow, y0: Floats, targets: Floats) -> Iterator[State]:
        """See :class:`planner.gabf.solvers.Solver`; targets are read off the dense output."""
        from scipy.integrate import RK45  # 0.3 s, so not at import

        left = [float(t) for t in targets[::-1]]
        stepper = RK45(lambda _, y: _speed(problem, flow, y), 0.0, y0, np.inf, self.max_step, self.rtol, self.atol)
        yield _state(problem, 0.0, y0, 1)
        while True:
            stepper.step()
            if stepper.status == "failed":
                raise AssumptionError(f"SciPy's RK45 gave up at tau = {stepper.t:g}: use Splitting() instead")
            while left and left[-1] < float(stepper.t):
                tau = left.pop()
                if stepper.t_old is not None and tau > stepper.t_old:
                    yield _state(problem, tau, stepper.dense_output()(tau), stepper.nfev)
            yield _state(problem, stepper.t, stepper.y.copy(), stepper.nfev)


@dataclass(frozen=True)
class BackwardEuler(Solver):
    """y_new = y - dtau phi(y_new - m(y_new)): the implicit method of remark (implementation), in tau.

    For given parent values m each node's equation has one root; m is iterated to its fixed point (a
    contraction for L <= 1). A smaller ``step`` in tau is more accurate,
    order 1, and takes proportionally more steps.
    """

    step: float = 0.05
    order: ClassVar[int] = 1
    exact_rest: ClassVar[bool] = False
    name: ClassVar[str] = "backward-euler"

    def __post_init__(self) -> None:
        if not self.step > 0:
            raise OptionError("step of the backward Euler solver must be positive")

    def states(self, problem: Problem, flow: Flow, y0: Floats, targets: Floats) -> Iterator[State]:
        """See :class:`planner.gabf.solvers.Solver`."""
        landing, tau, y, count = Targets(targets), 0.0, y0, 1
        while True:
            yield _state(problem, tau, y, count)
            dtau, tau = landing.clip(tau, self.step)
            y, sweeps = implicit_step(problem, flow, y, dtau)
            count += sweeps + 1


def right_side(net: Network, law: Law) -> Callable[[float, Floats], Floats]:
    """(t, x) -> dx/dt in the paper's own time, for any ODE solver: x (n,), 0 where no source is reached.

    Near T_p the gain grows without bound and t stops resolving T_p - t; that is what integrating in tau
    avoids.
    """
    problem = reduce(net)

    def speed(t: float, x: Floats) -> Floats:
        xhat = problem.disequilibrium(problem.pack(x))
        return problem.unpack(control_input(law, law.clock.tau(t), xhat), missing=0.0)

    return speed


def _speed(problem: Problem, flow: Flow, y: Floats) -> Floats:
    return np.concatenate((-flow.rate(problem.disequilibrium(y)), np.zeros(problem.anchors.size)))


def _state(problem: Problem, tau: float, y: Floats, count: int) -> State:
    return State(tau, problem.standing(y), count)


def implicit_step(problem: Problem, flow: Flow, y: Floats, dtau: float) -> tuple[Floats, int]:
    """The packed states after a backward Euler step of ``dtau`` from ``y``, and the sweeps that it took.

    AssumptionError where the parent values do not come to rest.
    """
    rows, scale = problem.n_rows, max(1.0, float(np.abs(y).max()))
    guess, sweeps = y, 0
    while True:
        m = problem.parent_values(guess)
        root = problem.with_sources(m + flow.resolvent(y[:rows] - m, dtau))
        change, sweeps, guess = float(np.abs(root - guess).max()), sweeps + 1, root
        if change <= 1e-13 * scale:
            return guess, sweeps
        if sweeps >= 10_000:
            raise AssumptionError(f"a backward Euler step of {dtau:g} in tau does not converge: choose a smaller step")
