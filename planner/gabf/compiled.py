"""The splitting step compiled by Numba, for networks so large that it earns back its import and compilation.

The only file that imports Numba, which is optional: :func:`available` says whether it is there.
"""

from __future__ import annotations

import importlib.util
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from planner.arrays import Floats
from planner.gabf.arcmaps import AffineArcs
from planner.gabf.flows import Flow, PowerFlow
from planner.gabf.problem import Problem

if importlib.util.find_spec("numba") is None:

    def njit(function: Any) -> Any:
        return function
else:
    from numba import njit as _njit  # pyright: ignore[reportMissingImports]

    njit = _njit(cache=True)


def available(problem: Problem) -> bool:
    """Whether Numba is installed and the kernel is affine: a user's function stays in NumPy."""
    return importlib.util.find_spec("numba") is not None and isinstance(problem.arcs, AffineArcs)


@dataclass(frozen=True, eq=False)
class CompiledStepper:
    """Same results as :class:`planner.gabf.splitting.NumpyStepper`, up to the last bits of a power."""

    starts: Any
    heads: Any
    slope: Floats
    offset: Floats
    flow: tuple[float, ...]

    def disequilibrium(self, y: Floats) -> Floats:
        xhat = np.empty(self.starts.size - 1)
        _disequilibrium(self.starts, self.heads, self.slope, self.offset, y, xhat)
        return xhat

    def step(self, y: Floats, xhat: Floats, dtau: float, size: float) -> tuple[Floats, float]:
        y_next, y_mid = np.empty_like(y), np.empty_like(y)
        share = _step(
            self.starts, self.heads, self.slope, self.offset, self.flow, y, xhat, dtau, size, y_mid, y_next
        )
        return y_next, share


def compiled_stepper(problem: Problem, flow: Flow) -> CompiledStepper:
    arcs = problem.arcs
    assert isinstance(arcs, AffineArcs)
    kind = np.int32 if max(problem.heads.size, problem.nodes.size) < 2**31 else np.int64
    slope = np.empty(0) if arcs.slope is None else arcs.slope
    starts = np.append(problem.starts, problem.heads.size).astype(kind)
    return CompiledStepper(starts, problem.heads.astype(kind), slope, arcs.offset, _constants(flow))


def _constants(flow: Flow) -> tuple[float, ...]:
    """beta1, beta2, 1 - p, q - 1, 1/(1 - p), 1/(q - 1), and the same two as halves, 0 where they are none."""
    if not isinstance(flow, PowerFlow):
        return (0.0,) * 8
    roots = flow.roots
    halves = [float(r.numerator) if r.denominator == 2 and r <= 6 else 0.0 for r in roots]
    return (
        flow.beta1,
        flow.beta2,
        float(1 - flow.p),
        float(flow.q - 1),
        float(roots[0]),
        float(roots[1]),
        halves[0],
        halves[1],
    )


@njit
def _least(starts, heads, slope, offset, y, i):
    least = np.inf
    for k in range(starts[i], starts[i + 1]):
        value = y[heads[k]] * slope[k] + offset[k] if slope.size else y[heads[k]] + offset[k]
        if value < least:
            least = value
    return least


@njit
def _power(base, exponent, halves):
    if halves == 0.0:
        return base**exponent
    result = math.sqrt(base)
    for _ in range(int(halves) // 2):
        result *= base
    return result


@njit
def _sink(flow, size, dtau):
    rest = size ** flow[2] - flow[2] * flow[0] * dtau
    return _power(rest, flow[4], flow[6]) if rest > 0.0 else 0.0


@njit
def _brake(flow, size, dtau):
    return size / _power(1.0 + flow[3] * flow[1] * dtau * size ** flow[3], flow[5], flow[7])


@njit
def _advance(flow, s, dtau, decay):
    if s == 0.0:
        return 0.0
    if flow[0] == 0.0:
        return s * decay
    size = _sink(flow, abs(s), 0.5 * dtau)
    if size > 0.0:
        size = _sink(flow, _brake(flow, size, dtau), 0.5 * dtau)
    return math.copysign(size, s)


@njit
def _disequilibrium(starts, heads, slope, offset, y, xhat):
    for i in range(starts.size - 1):
        xhat[i] = y[i] - _least(starts, heads, slope, offset, y, i)


@njit
def _step(starts, heads, slope, offset, flow, y, xhat, dtau, size, y_mid, y_next):
    rows, share = starts.size - 1, 0.0
    for i in range(rows):
        y_mid[i] = y[i] - xhat[i] + _advance(flow, xhat[i], 0.5 * dtau, math.exp(-0.5 * dtau))
    for i in range(rows, y.size):
        y_mid[i] = y_next[i] = y[i]
    for i in range(rows):
        m = _least(starts, heads, slope, offset, y_mid, i)
        s = y[i] - m
        left = _advance(flow, s, dtau, math.exp(-dtau))
        y_next[i] = m + left
        moved = abs(m - (y[i] - xhat[i]))
        if moved > 0.0 and s != 0.0:
            share = max(share, moved * (1.0 - left / s) / (size + abs(xhat[i])))
    return share
