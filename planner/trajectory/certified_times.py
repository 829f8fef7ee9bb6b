"""Times at which something is proven, cell by cell, and only as far as they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import TypeAlias

import numpy as np

from planner.base.arrays import Bools, Floats

_CELL, _FINEST = 0.5, 1 / 64  # s: cells of time are halved from the one down to the other
_FIRST = 8  # cells of the first block
_PART = 32  # cells of a block that are worked out at once: more at a time are quicker, and more than may be asked for

Proven: TypeAlias = Callable[[Floats, Floats], Bools]
"""Which of the cells of time from ``low`` (n,) to ``high`` (n,) s are proven, each as a whole."""


class TimeGrid:
    """Cells of time from 0 to ``end`` (s), from when on nothing moves, in blocks, each as long as all before it."""

    def __init__(self, end: float) -> None:
        self.corners = np.linspace(0.0, end, int(np.ceil(end / _CELL)) + 1)

    @cached_property
    def _begins(self) -> list[int]:
        """The first cell of each block; the last block is all that comes after the end."""
        begins, last = [0], len(self.corners) - 1
        while begins[-1] < last:
            begins.append(min(max(_FIRST, 2 * begins[-1]), last))
        return begins

    @cached_property
    def _times(self) -> Floats:
        """When each block begins, s."""
        return self.corners[self._begins]

    def blocks(self, low: float, high: float) -> range:
        """The numbers of the blocks that hold [low, high] s."""
        first = int(np.searchsorted(self._times, low, side="right")) - 1
        return range(first, max(first + 1, int(np.searchsorted(self._times, high, side="left"))))

    def corners_of(self, block: int) -> Floats:
        """The corners (n + 1,) of the cells of a block; of the last one, which has no cells, the end (1,)."""
        begin, after = self._begins[block], [*self._begins, len(self.corners) - 1][block + 1]
        return self.corners[begin : after + 1]

    def horizons(self, least: float) -> Iterator[float]:
        """Until when (s) whole blocks reach that hold ``least``, one block more each time; inf is the last."""
        yield from (float(time) for time in self._times[1:] if time >= least)
        yield np.inf


class CertifiedTimes:
    """When something is ``proven``, worked out block by block as it is asked for, and kept."""

    def __init__(self, proven: Proven, grid: TimeGrid) -> None:
        self._proven, self._grid = proven, grid
        self._blocks: dict[int, Floats] = {}
        self._known: dict[tuple[float, float], Floats | None] = {}
        self._joined: dict[range, Floats] = {}

    def within(self, low: float, high: float) -> Floats:
        """Stretches (k, 2) of time, ascending, which do not touch; all that are proven of the blocks of [low, high]."""
        blocks = self._grid.blocks(low, high)
        if blocks not in self._joined:
            self._joined[blocks] = _joined(np.concatenate([self._block(block) for block in blocks]))
        return self._joined[blocks]

    def first(self, low: float, high: float) -> float:
        """The first time (s) of [low, high] that is proven; inf for none. What ends before or comes after is left."""
        for block in self._grid.blocks(low, high):
            for stretches in self._parts(self._grid.corners_of(block), low):
                row = int(np.searchsorted(stretches[:, 1], low))
                if row < len(stretches):
                    found = max(low, float(stretches[row, 0]))
                    return found if found <= high else np.inf
        return np.inf

    def _block(self, block: int) -> Floats:
        if block not in self._blocks:
            self._blocks[block] = np.concatenate(list(self._parts(self._grid.corners_of(block))))
        return self._blocks[block]

    def _parts(self, corners: Floats, low: float = 0.0) -> Iterator[Floats]:
        """The stretches of a block, ascending, in parts that do not end before ``low``; as :func:`certified_cells`."""
        end = np.inf if len(corners) == 1 else float(corners[-1])
        part, middle = (float(corners[0]), end), (len(corners) - 1) // 2
        if end < low:
            return
        if part not in self._known:
            self._known[part] = self._whole(corners)
        known = self._known[part]
        if known is not None:
            yield known
        else:
            yield from self._parts(corners[: middle + 1], low)
            yield from self._parts(corners[middle:], low)

    def _whole(self, corners: Floats) -> Floats | None:
        """The stretches of a part that is short or proven at once; None for others."""
        if len(corners) == 1:
            return self._after(corners)
        if len(corners) - 1 <= _PART:
            return _joined(certified_cells(self._proven, corners))
        return corners[[0, -1]][None] if self._proven(corners[:1], corners[-1:])[0] else None

    def _after(self, end: Floats) -> Floats:
        return np.array([[end[0], np.inf]]) if self._proven(end, end)[0] else np.zeros((0, 2))

    def for_good_from(self) -> float:
        """The time (s) from which on all is proven; inf where there is none.

        Looked for from the end: what is proven as a whole is not looked into.
        """
        corners, since = self._grid.corners, np.inf
        if len(self._after(corners[-1:])):
            since, waiting = float(corners[-1]), [(0, len(corners) - 1)]
            while waiting:
                first, last = waiting.pop()
                if first == last:
                    continue
                if self._proven(corners[first : first + 1], corners[last : last + 1])[0]:
                    since = float(corners[first])
                elif last - first > 1:
                    waiting += [(first, (first + last) // 2), ((first + last) // 2, last)]
                else:
                    cells = _joined(_halves(self._proven, corners[first : first + 1], corners[last : last + 1]))
                    return float(cells[-1, 0]) if len(cells) and cells[-1, 1] == since else since
        return since


def certified_cells(proven: Proven, corners: Floats) -> Floats:
    """Cells (k, 2) from the first to the last of ``corners`` (n + 1,) that are proven, in no order.

    All of it is asked for at once; what is not proven by halves, cells down to 1/64 s.
    """
    first, last = np.array([0]), np.array([len(corners) - 1])
    found, single = [np.zeros((0, 2))], []
    while len(first):
        low, high = corners[first], corners[last]
        free = proven(low, high)
        found.append(np.column_stack([low, high])[free])
        first, last = first[~free], last[~free]
        single.append(first[last - first == 1])
        first, last = first[last - first > 1], last[last - first > 1]
        middle = (first + last) // 2
        first, last = np.concatenate([first, middle]), np.concatenate([middle, last])
    cells = np.concatenate(single)
    return np.concatenate([*found, _halves(proven, corners[cells], corners[cells + 1])])


def _halves(proven: Proven, low: Floats, high: Floats) -> Floats:
    """Parts (k, 2) that are proven of cells from ``low`` to ``high`` (n,), which as a whole are not."""
    found = [np.zeros((0, 2))]
    while True:
        wide = high - low > _FINEST
        low, high = low[wide], high[wide]
        if not len(low):
            return np.concatenate(found)
        middle = 0.5 * (low + high)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        free = proven(low, high)
        found.append(np.column_stack([low, high])[free])
        low, high = low[~free], high[~free]


def _joined(cells: Floats) -> Floats:
    """Cells (n, 2) that meet at their ends as one."""
    cells = cells[np.argsort(cells[:, 0], kind="stable")]
    if not len(cells):
        return cells
    begins = np.concatenate([[True], cells[1:, 0] > cells[:-1, 1]])
    ends = np.concatenate([begins[1:], [True]])
    return np.column_stack([cells[begins, 0], cells[ends, 1]])
