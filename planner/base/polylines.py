"""Paths of straight motions: how long they are so far, and cut into equal parts."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints, so_far


def lengths_along(path: Floats) -> Floats:
    """How far (k,) each row of a ``path`` (k, n) is from its beginning, along it."""
    return so_far(lengths_of(path))


def lengths_of(path: Floats) -> Floats:
    """The lengths (k - 1,) of the segments of a ``path`` (k, n)."""
    return np.linalg.norm(np.diff(path, axis=0), axis=1)


def cut(path: Floats, parts: Ints, delta: Floats | None = None) -> Floats:
    """``path`` (k, n) with segment i cut into ``parts[i]`` equal ones; its own rows stay as they are, to the bit.

    Row ``parts[:i].sum()`` of the result is row i of ``path``. ``delta`` (k - 1, n): the motion along each segment,
    where that is not the difference of its ends, as for joints that turn past pi.
    """
    delta = np.diff(path, axis=0) if delta is None else delta
    segment = np.repeat(np.arange(len(parts)), parts)
    first = so_far(parts)
    number = np.arange(len(segment)) - first[segment]
    rows = path[segment] + (number / parts[segment])[:, None] * delta[segment]
    rows = np.concatenate([rows, path[-1:]])
    rows[first] = path
    return rows


def parts_of(lengths: Floats, longest: float) -> Ints:
    """Into how many parts (m,) segments of ``lengths`` (m,) are cut so that none is longer than ``longest``."""
    return np.maximum(1, np.ceil(lengths / longest)).astype(np.int64)
