"""What the compiled library does for the dynamics: hops, parent values of rows, and how rows move towards them.

Arrays are float64 in C order; ``rows`` are the rows that are looked at, None for all of them.
"""

from __future__ import annotations

import weakref

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.native.loading import address, floats, ints, library, threads

STRANG, BRAKE_THEN_SINK, SINK_THEN_BRAKE = 0, 1, 2
"""The order in which the powers above 1 (brake) and below 1 (sink) act over a step; Strang: half, full, half."""


_SHARED_FROM = 16_384
"""Rows from which a thread more gains more than it costs to start."""


def hops_to_source(indptr: Ints, heads: Ints, sources: Ints) -> Ints:
    """(n,) fewest arcs from each node to a source, -1 where there is no path.

    Node i reads the nodes ``heads[indptr[i]:indptr[i + 1]]``.
    """
    indptr, heads, sources = ints(indptr), ints(heads), ints(sources)
    hops = np.empty(indptr.size - 1, dtype=np.int64)
    library.arcs_hops(hops.size, address(indptr), address(heads), sources.size, address(sources), address(hops))
    return hops


class NativeArcs:
    """The arcs of R rows: row i reads ``heads[starts[i]:starts[i + 1]]`` as slope y + offset; no ``slope``: 1."""

    def __init__(self, starts: Ints, heads: Ints, slope: Floats | None, offset: Floats) -> None:
        first, heads = np.append(ints(starts), heads.size), ints(heads)
        slope, offset = None if slope is None else floats(slope), floats(offset)
        self._n_rows = starts.size
        self.handle = library.arcs_new(
            starts.size, heads.size, address(first), address(heads), _address(slope), address(offset)
        )
        weakref.finalize(self, library.arcs_free, self.handle)

    def parent_values(self, rows: Ints | None, y: Floats) -> Floats:
        """(rows,) the least of each row's arcs at states ``y``."""
        values = np.empty(self._n_rows if rows is None else rows.size)
        y = floats(y)
        library.arcs_parent_values(
            self.handle, values.size, _address(rows), address(y), _threads(values.size), address(values)
        )
        return values

    def step(
        self, flow: NativeFlow, rows: Ints | None, y: Floats, xhat: Floats, half: float, dtau: float, size: float
    ) -> tuple[Floats, Floats, float, float, float, float, float]:
        """What follows ``y`` after ``dtau``, what :meth:`standing` says of it, and how far off it may be.

        Parent values are those at :meth:`NativeFlow.sketch` after ``half``; the last as :meth:`NativeFlow.advance`.
        """
        y, xhat, found = floats(y), floats(xhat), np.empty(y.size + self._n_rows + 5)
        count = self._n_rows if rows is None else rows.size
        pointers = _address(rows), self._n_rows, y.size, address(y), address(xhat)
        numbers = half, dtau, size, _threads(count)
        library.arcs_step(self.handle, flow.handle, count, *pointers, *numbers, address(found))
        residual, lowest, highest, lowest_moving, off = found[-5:].tolist()
        return found[: y.size], found[y.size : -5], residual, lowest, highest, lowest_moving, off

    def standing(self, rows: Ints | None, y: Floats) -> tuple[Floats, float, float, float, float]:
        """y - m (R,), 0 but at ``rows``, and the largest of its sizes; the least and the largest y of all R rows.

        Last the least of y and m of the rows where they differ; inf where none does.
        """
        y, xhat, numbers = floats(y), np.zeros(self._n_rows), np.empty(4)
        count = xhat.size if rows is None else rows.size
        found = address(xhat), address(numbers)
        library.arcs_standing(self.handle, count, _address(rows), xhat.size, address(y), _threads(xhat.size), *found)
        residual, lowest, highest, lowest_moving = numbers.tolist()
        return xhat, residual, lowest, highest, lowest_moving


class NativeFlow:
    """s' = -(beta1 |s|^(1 - below) + beta2 |s|^(1 + above)) sgn(s), or s' = -s where ``below`` is 0."""

    def __init__(self, beta1: float, beta2: float, below: float, above: float) -> None:
        self._numbers = np.array([beta1, beta2, below, above])
        self.handle = address(self._numbers)

    def moved(self, order: int, s: Floats, dtau: float) -> Floats:
        """s after ``dtau``, to 1e-13 relative; 0 stays 0, and no |s| grows."""
        s = floats(s)
        moved = np.empty(s.shape)
        library.flow_moved(self.handle, order, s.size, address(s), dtau, _threads(s.size), address(moved))
        return moved

    def sketch(self, rows: Ints | None, y: Floats, xhat: Floats, dtau: float, following: Floats) -> None:
        """Write into ``following`` the rows' y after ``dtau``, the brake before the sink; ``xhat`` (R,) is y - m."""
        y, xhat = floats(y), floats(xhat)
        count = xhat.size if rows is None else rows.size
        library.flow_sketch(
            self.handle, count, _address(rows), address(y), address(xhat), dtau, _threads(count), address(following)
        )

    def advance(
        self, rows: Ints | None, m: Floats, y: Floats, xhat: Floats, dtau: float, size: float, following: Floats
    ) -> float:
        """Write into ``following`` the rows' y after ``dtau`` by Strang's rule, with parents at ``m`` (rows,).

        How far off that may be, as a share of ``size`` + \\|xhat\\|: :meth:`planner.gabf.splitting.Stepper.advance`.
        """
        m, y, xhat = floats(m), floats(y), floats(xhat)
        pointers = _address(rows), address(m), address(y), address(xhat)
        return library.flow_advance(self.handle, m.size, *pointers, dtau, size, _threads(m.size), address(following))


def _threads(count: int) -> int:
    return threads() if count >= _SHARED_FROM else 1


def _address(array: Floats | Ints | None) -> int | None:
    return None if array is None else address(array)
