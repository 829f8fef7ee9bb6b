"""toppra's time parametrization along the same curve, to be compared with where it is installed."""

from __future__ import annotations

import importlib.util
from itertools import pairwise

import numpy as np

from planner.base.arrays import Floats, cumulative_sums
from planner.trajectory.curve import Curve

_GRID = 30  # intervals of a piece


def installed() -> bool:
    """Whether toppra is there."""
    return importlib.util.find_spec("toppra") is not None


def toppra_duration(curve: Curve, velocity: Floats, acceleration: Floats) -> float:
    """Seconds that toppra takes along ``curve``, from stop to stop; limits (dof,), at its own grid points."""
    ends = [-1, *np.flatnonzero(curve.stop).tolist()]
    return sum(
        _between_stops(curve.coefficients[a + 1 : b + 1], velocity, acceleration) for a, b in pairwise(ends) if b > a
    )


def _between_stops(pieces: Floats, velocity: Floats, acceleration: Floats) -> float:
    import toppra  # pyright: ignore[reportMissingImports]
    from toppra import algorithm, constraint  # pyright: ignore[reportMissingImports]

    toppra.setup_logging("ERROR")
    path = _path(pieces)
    limits = [np.stack([-most, most], axis=1) for most in (velocity, acceleration)]
    scheme = constraint.DiscretizationType.Interpolation
    of_velocity = constraint.JointVelocityConstraint(limits[0])
    of_acceleration = constraint.JointAccelerationConstraint(limits[1], discretization_scheme=scheme)
    law = algorithm.TOPPRA([of_velocity, of_acceleration], path, gridpoints=path.grid, solver_wrapper="seidel")
    speed = law.compute_parameterization(0.0, 0.0)[1]
    return float("nan") if speed is None else float((2 * np.diff(path.grid) / (speed[1:] + speed[:-1])).sum())


def _path(pieces: Floats):
    """The pieces as one path whose derivative by its parameter has no jump."""
    from toppra.interpolator import AbstractGeometricPath  # pyright: ignore[reportMissingImports]

    lengths = [float(np.linalg.norm(pieces[0, 1]))]
    for before, after in pairwise(pieces):
        lengths.append(lengths[-1] * float(np.linalg.norm(after[1]) / np.linalg.norm(before[1] + 2 * before[2])))
    edges = cumulative_sums(lengths)

    class Pieces(AbstractGeometricPath):
        grid = np.unique(np.concatenate([np.linspace(a, b, _GRID + 1) for a, b in pairwise(edges)]))

        def __call__(self, path_positions, order: int = 0):
            s = np.atleast_1d(path_positions)
            k = np.clip(np.searchsorted(edges, s, side="right") - 1, 0, len(pieces) - 1)
            length = np.array(lengths)[k, None]
            u, (c0, c1, c2) = (s[:, None] - edges[k, None]) / length, np.moveaxis(pieces[k], 1, 0)
            found = (c0 + (c1 + c2 * u) * u, (c1 + 2 * c2 * u) / length, 2 * c2 / length**2)[order]
            return found if np.ndim(path_positions) else found[0]

        @property
        def dof(self) -> int:
            return pieces.shape[2]

        @property
        def path_interval(self):
            return edges[[0, -1]]

    return Pieces()
