"""What the compiled library does for the dynamics: hops, parent values of rows, and how rows move towards them.

Arrays are float64 in C order; ``rows`` are the rows that are looked at, None for all of them. :class:`ArrayError` where
arrays are not of the shapes that stand here, or an index is out of range.
"""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import ArrayError
from planner.native.loading import address, floats, given_back, ints, library, threads

STRANG, BRAKE_THEN_SINK, SINK_THEN_BRAKE = 0, 1, 2
"""The order in which the powers above 1 (brake) and below 1 (sink) act over a step; Strang: half, full, half."""


_SHARED_FROM = 16_384
"""Rows from which a thread more gains more than it costs to start."""


def hops_to_source(indptr: Ints, heads: Ints, sources: Ints) -> Ints:
    """(n,) fewest arcs from each node to a source, -1 where there is no path.

    Node i reads the nodes ``heads[indptr[i]:indptr[i + 1]]``.
    """
    n, m, k = len(indptr) - 1, len(heads), len(sources)
    indptr, heads, sources = ints(indptr, n + 1), ints(heads, m), ints(sources, k)
    hops = np.empty(n, dtype=np.int64)
    library.arcs_hops(n, address(indptr), m, address(heads), k, address(sources), address(hops))
    return hops


class NativeArcs:
    """The arcs of R rows: row i reads ``heads[starts[i]:starts[i + 1]]`` as slope y + offset; no ``slope``: 1."""

    def __init__(self, starts: Ints, heads: Ints, slope: Floats | None, offset: Floats) -> None:
        self._n_rows, m = len(starts), len(heads)
        first, heads = np.append(ints(starts, self._n_rows), m), ints(heads, m)
        slope, offset = None if slope is None else floats(slope, m), floats(offset, m)
        self.handle = library.arcs_new(
            self._n_rows, m, address(first), address(heads), _address(slope), address(offset)
        )
        given_back(self, library.arcs_free, self.handle)

    def parent_values(self, rows: Ints | None, y: Floats) -> Floats:
        """(rows,) the least of each row's arcs at states ``y``."""
        y, rows, count = floats(y, len(y)), *_chosen(rows, self._n_rows)
        values = np.empty(count)
        states = y.size, address(y)
        library.arcs_parent_values(self.handle, count, _address(rows), *states, _threads(count), address(values))
        return values

    def step(
        self, flow: NativeFlow, rows: Ints | None, y: Floats, xhat: Floats, half: float, dtau: float, size: float
    ) -> tuple[Floats, Floats, float, float, float, float, float]:
        """What follows ``y`` after ``dtau``, what :meth:`standing` says of it, and how far off it may be.

        Parent values are those at :meth:`NativeFlow.sketch` after ``half``; the last as :meth:`NativeFlow.advance`.
        """
        y, xhat, found = floats(y, len(y)), floats(xhat, self._n_rows), np.empty(len(y) + self._n_rows + 5)
        rows, count = _chosen(rows, self._n_rows)
        pointers = _address(rows), y.size, address(y), address(xhat)
        numbers = half, dtau, size, _threads(count)
        library.arcs_step(self.handle, flow.handle, count, *pointers, *numbers, address(found))
        residual, lowest, highest, lowest_moving, off = found[-5:].tolist()
        return found[: y.size], found[y.size : -5], residual, lowest, highest, lowest_moving, off

    def standing(self, rows: Ints | None, y: Floats) -> tuple[Floats, float, float, float, float]:
        """y - m (R,), 0 but at ``rows``, and the largest of its sizes; the least and the largest y of all R rows.

        Last the least of y and m of the rows where they differ; inf where none does.
        """
        y, xhat, numbers = floats(y, len(y)), np.zeros(self._n_rows), np.empty(4)
        rows, count = _chosen(rows, self._n_rows)
        states, found = (y.size, address(y)), (address(xhat), address(numbers))
        library.arcs_standing(self.handle, count, _address(rows), *states, _threads(xhat.size), *found)
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
        y, xhat, (rows, count) = floats(y, len(y)), floats(xhat, len(xhat)), _chosen(rows, len(xhat))
        _require_room(len(xhat), y, following)
        pointers = _address(rows), xhat.size, address(y), address(xhat)
        library.flow_sketch(self.handle, count, *pointers, dtau, _threads(count), address(following))

    def advance(
        self, rows: Ints | None, m: Floats, y: Floats, xhat: Floats, dtau: float, size: float, following: Floats
    ) -> float:
        """Write into ``following`` the rows' y after ``dtau`` by Strang's rule, with parents at ``m`` (rows,).

        How far off that may be, as a share of ``size`` + \\|xhat\\|: :meth:`planner.gabf.splitting.Parents.step`.
        """
        y, xhat, (rows, count) = floats(y, len(y)), floats(xhat, len(xhat)), _chosen(rows, len(xhat))
        m = floats(m, count)
        _require_room(len(xhat), y, following)
        pointers = _address(rows), xhat.size, address(m), address(y), address(xhat)
        return library.flow_advance(self.handle, count, *pointers, dtau, size, _threads(count), address(following))


def _chosen(rows: Ints | None, n_rows: int) -> tuple[Ints | None, int]:
    """The rows that are looked at, and how many they are."""
    return (None, n_rows) if rows is None else (ints(rows, len(rows)), len(rows))


def _require_room(rows: int, y: Floats, following: Floats) -> None:
    """Refuse states ``y`` that are fewer than ``rows``, and an array that as many cannot be written into."""
    layout = following.flags
    if not (layout.writeable and layout.c_contiguous and following.dtype == np.float64):
        raise ArrayError(f"what follows is written into float64 in C order, not into {following.dtype}.")
    if following.ndim != 1 or min(y.size, following.size) < rows:
        raise ArrayError(f"{rows} rows were given, and {y.size} states and room for {following.size} of them.")


def _threads(count: int) -> int:
    return threads() if count >= _SHARED_FROM else 1


def _address(array: Floats | Ints | None) -> int | None:
    return None if array is None else address(array)
