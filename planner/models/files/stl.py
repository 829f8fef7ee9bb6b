"""Binary STL files as arrays: large ones are read in a hundredth of the time that Assimp takes."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats

_HEADER, _RECORD = 84, 50  # bytes before the triangles, and of each: normal, three corners, two bytes


def binary_stl(content: bytes) -> Floats | None:
    """The corners (m, 3, 3) of the triangles of a binary STL file, in the file's own unit; None for any other file."""
    if len(content) < _HEADER:
        return None
    count = int.from_bytes(content[_HEADER - 4 : _HEADER], "little")
    if not count or len(content) != _HEADER + _RECORD * count:
        return None
    records = np.frombuffer(content, dtype=np.uint8, offset=_HEADER).reshape(count, _RECORD)
    return np.ascontiguousarray(records[:, 12:48]).view("<f4").reshape(count, 3, 3).astype(np.float64)
