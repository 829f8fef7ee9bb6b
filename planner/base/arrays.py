"""Array aliases, named by what they hold, index arithmetic, and what public functions ask of arrays.

Shapes stand in the docstrings that use the aliases.
"""

from __future__ import annotations

import math
from typing import Any, NoReturn, TypeAlias

import numpy as np
from numpy.typing import NDArray

from planner.base.errors import ArrayError, PlannerError

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]


def frozen(array: Any, dtype: Any = np.float64) -> NDArray[Any]:
    """A read-only, contiguous copy of ``array`` with the given dtype."""
    result = np.array(array, dtype=dtype, order="C", copy=True)
    result.setflags(write=False)
    return result


def ranges(starts: Ints, counts: Ints) -> Ints:
    """starts[k], starts[k] + 1, ... counts[k] of them, for every k in turn."""
    ends = np.cumsum(counts)
    return np.repeat(starts - (ends - counts), counts) + np.arange(counts.sum())


def so_far(values: Any) -> Any:
    """The sums (n + 1,) of the first 0, 1, 2, ... of ``values`` (n,)."""
    values = np.asarray(values)
    return np.concatenate([np.zeros(1, dtype=values.dtype), np.cumsum(values)])


def distinct_rows(rows: NDArray[Any]) -> tuple[Ints, Ints]:
    """Of equal rows (n, k) the first: their indices (m,), rows ascending, and which of these each row is (n,).

    As ``np.unique(rows, axis=0, return_index=True, return_inverse=True)`` in a sixth of the time.
    """
    order = np.lexsort(rows.T[::-1])
    ascending, fresh = rows[order], np.ones(len(rows), dtype=bool)
    fresh[1:] = (ascending[1:] != ascending[:-1]).any(axis=1)
    which = np.empty(len(rows), dtype=np.int64)
    which[order] = np.cumsum(fresh) - 1
    return order[fresh], which


def row_bytes(rows: Floats) -> list[bytes]:
    """Every row (m, k) as its bytes: equal where all of its bits are."""
    data, width = rows.tobytes(), rows.nbytes // max(len(rows), 1)
    return [data[k * width : (k + 1) * width] for k in range(len(rows))]


def quantile(values: Floats, share: float) -> float:
    """What a ``share`` of the values (n,) lies below, as ``np.quantile`` says it, which loads NumPy's masked arrays."""
    ascending, at = np.sort(values), share * (len(values) - 1)
    below, above = ascending[[math.floor(at), math.ceil(at)]].tolist()
    return below + (at - math.floor(at)) * (above - below)


def as_frozen(array: Any, dtype: Any = np.float64) -> NDArray[Any]:
    """``array`` itself where it is what :func:`frozen` would make of it, else that copy."""
    value = np.asarray(array)
    as_it_is = value.dtype == dtype and value.flags.c_contiguous and not value.flags.writeable
    return value if as_it_is else frozen(value, dtype)


Shape: TypeAlias = tuple[int | str, ...]
"""A text stands for any number of rows: ("n", 7)."""


def numbers(
    what: str, values: Any, shape: Shape, error: type[PlannerError] = ArrayError, most: float = np.inf
) -> Floats:
    """``values`` as float64 of a ``shape``, finite and within ``most`` of 0; not copied where they are that already.

    Otherwise ``error``, in one sentence that names ``what`` they are. For arrays that enter a public function.
    """
    return _fitting(what, _read(what, values, shape, error), shape, error, most)


def plain_numbers(what: str, values: Any, error: type[PlannerError] = ArrayError) -> Floats:
    """``values`` as float64, whatever their shape and size; ``error`` where they are no numbers."""
    return _read(what, values, ("...",), error)


def rows(what: str, values: Any, width: int, error: type[PlannerError] = ArrayError, most: float = np.inf) -> Floats:
    """As :func:`numbers`, of shape (n, width); one row alone (width,) becomes (1, width)."""
    shape = ("n", width)
    array = _read(what, values, shape, error)
    return _fitting(what, array[None] if array.shape == (width,) else array, shape, error, most)


def truths(what: str, values: Any, shape: Shape, error: type[PlannerError] = ArrayError) -> Bools:
    """``values`` as truth values of a ``shape``; otherwise as :func:`numbers`."""
    given = np.asarray(values)
    if given.dtype.kind != "b" and given.size:
        raise error(f"{what} is no array of truth values: give one of shape {_text(shape)}.")
    return _shaped(what, given, shape, error)


def indices(what: str, values: Any, shape: Shape, count: int, error: type[PlannerError] = ArrayError) -> Ints:
    """``values`` as int64 of a ``shape``, from 0 to ``count`` - 1; otherwise as :func:`numbers`."""
    given = _shaped(what, _read(what, values, shape, error), shape, error)
    fits = (given >= 0) & (given < count) & (given == np.floor(given))
    if not fits.all():
        _refuse(what, given, fits, f"give whole numbers from 0 to {count - 1}", error)
    return given.astype(np.int64)


def placement(what: str, values: Any, error: type[PlannerError] = ArrayError, most: float = np.inf) -> Floats:
    """``values`` as a rigid placement (4, 4): rotation, position, and 0 0 0 1 below; otherwise as :func:`numbers`.

    A rotation that is rounded, by 1e-6 at most, becomes the nearest one: scaled bodies would be other bodies.
    """
    array = numbers(what, values, (4, 4), error, most)
    turn, last = array[:3, :3], np.array([0.0, 0.0, 0.0, 1.0])
    off = np.abs(turn @ turn.T - np.eye(3)).max()
    if off > 1e-6 or np.linalg.det(turn) <= 0 or np.abs(array[3] - last).max() > 1e-9:
        raise error(f"{what} is not rigid: give a (4, 4) placement, as planner.pose makes it.")
    if off > _ROUNDED:
        left, _, right = np.linalg.svd(turn)
        array = frozen(np.vstack([np.column_stack([left @ right, array[:3, 3]]), last]))
    return array


_ROUNDED = 1e-12
_FLOAT = np.dtype(np.float64)
_LONG = 5000  # numbers


def _read(what: str, values: Any, shape: Shape, error: type[PlannerError]) -> Floats:
    if type(values) is np.ndarray and values.dtype is _FLOAT:
        return values
    try:
        given = np.asarray(values)
        if given.dtype.kind in "fiu" or (given.dtype.kind == "O" and not any(map(_is_text, given.flat))):
            return given.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):
        pass
    raise error(f"{what} is no array of numbers: give one of shape {_text(shape)}.")


def _is_text(value: Any) -> bool:
    return isinstance(value, bool | str | bytes)  # NumPy makes numbers of true, and of "0_3"


def _shaped(what: str, array: NDArray[Any], shape: Shape, error: type[PlannerError]) -> NDArray[Any]:
    there = array.shape
    alike = len(there) == len(shape)
    for size, wanted in zip(there, shape, strict=False):
        alike = alike and (size == wanted or type(wanted) is str)
    if not alike:
        raise error(f"{what} has shape {there}: give an array of shape {_text(shape)}.")
    return array


def _fitting(what: str, array: Floats, shape: Shape, error: type[PlannerError], most: float) -> Floats:
    _shaped(what, array, shape, error)
    if not _square(array) < min(most, 1e150) ** 2:  # a look at all of them at once takes a third of the time
        fits = np.abs(array) <= most if most < np.inf else np.isfinite(array)
        if not fits.all():
            limit = "" if most == np.inf else f", no farther than {most:g} from 0"
            _refuse(what, array, fits, f"every number has to be finite{limit}", error)
    return array


def _square(array: Floats) -> float:
    """The sum of all squares. BLAS shares out long ones to threads, which wait for each other longer than it takes."""
    flat = array.ravel()
    return float(np.vdot(flat, flat) if array.size < _LONG else np.einsum("i,i->", flat, flat))


def _text(shape: Shape) -> str:
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"


def _refuse(what: str, array: Floats, fits: NDArray[np.bool_], remedy: str, error: type[PlannerError]) -> NoReturn:
    at = tuple(int(k) for k in np.argwhere(~fits)[0])
    where = f"[{', '.join(map(str, at))}]" if at else ""
    raise error(f"{what}{where} is {array[at]:g}: {remedy}.")
