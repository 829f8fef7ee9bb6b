"""The compiled walk along joint paths: how far points move at most on each part of them."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.native.loading import address as _at
from planner.native.loading import floats as _floats
from planner.native.loading import library as _library
from planner.native.loading import threads
from planner.native.world import NativeBounds, NativeWorld


def walk(world: NativeWorld, bounds: NativeBounds, coefficients: Floats, longest: float) -> tuple[Ints, Floats, Floats]:
    """Into how many parts of one length in s each of m pieces is cut, (m,), and how far no point moves on each part.

    ``coefficients`` (m, degree + 1, dof) of q(s), s in [0, 1]. Parts are so short that the joints alone could move
    nothing farther than ``longest`` (m). The metres (all parts,) hold for a part of a part in proportion. With them
    shares (pairs,): by how much at most a pair's distance changes meanwhile, of what the fastest point moves.
    """
    m = len(coefficients)
    coefficients = _floats(coefficients, m, coefficients.shape[1], world.dof)
    parts, shares = np.empty(m, dtype=np.int64), np.empty(world.pairs)
    reach, body_reach, _ = bounds.addresses
    pieces = body_reach, _at(coefficients), m, coefficients.shape[1] - 1
    moved = np.empty(_library.world_parts(world.handle, *pieces, longest, _at(parts)))
    _library.world_walk(world.handle, reach, *pieces, _at(parts), threads(), _at(moved), _at(shares))
    return parts, moved, shares
