"""Array aliases, named by what they hold; shapes stand in the docstrings that use them."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]


def frozen(array: Any, dtype: Any = np.float64) -> NDArray[Any]:
    """A read-only, contiguous copy of ``array`` with the given dtype."""
    result = np.array(array, dtype=dtype, order="C", copy=True)
    result.setflags(write=False)
    return result
