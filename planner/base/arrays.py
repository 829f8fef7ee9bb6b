"""Array aliases, arithmetic on arrays and paths of rows, and what public functions ask of arrays.

Shapes stand in the docstrings that use the aliases.

:func:`product`, :func:`dot` and :func:`length` have the same last bits on every processor that a plan promises them
for. NumPy leaves ``@`` and ``np.linalg`` to BLAS and LAPACK, which choose their code by the processor: of twenty kinds
of products that planning asks for, eleven differed between OpenBLAS' code for AVX-512 and for AVX2, and one last bit
can change the roadmap. Products that sum over three terms are left to ``@``: all code for FMA adds these up alike.
"""

import math
from typing import Any, NoReturn, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from planner.base.errors import ArrayError, PlannerError

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]
Shape: TypeAlias = tuple[int | str, ...]
"""A text stands for any number of rows: ("n", 7)."""
Cost = TypeVar("Cost", float, Floats)

_ROUNDED = 1e-12  # of a rotation


def frozen(array: Any, dtype: Any = np.float64) -> NDArray[Any]:
    """A read-only, contiguous array of the given dtype: a copy, except of an array that is one already."""
    value = np.asarray(array)
    if value.dtype == dtype and value.flags.c_contiguous and not value.flags.writeable:
        return value
    result = np.array(array, dtype=dtype, order="C", copy=True)
    result.setflags(write=False)
    return result


def ranges(starts: Ints, counts: Ints) -> Ints:
    """starts[k], starts[k] + 1, ... counts[k] of them, for every k in turn."""
    ends = np.cumsum(counts)
    return np.repeat(starts - (ends - counts), counts) + np.arange(counts.sum())


def cumulative_sums(values: Any) -> Any:
    """The sums (n + 1,) of the first 0, 1, 2, ... of ``values`` (n,)."""
    values = np.asarray(values)
    return np.concatenate([np.zeros(1, dtype=values.dtype), np.cumsum(values)])


def distinct_rows(rows: NDArray[Any]) -> tuple[Ints, Ints]:
    """Of equal rows (n, k) the first: their indices (m,), rows ascending, and which of these each row is (n,)."""
    _, first, which = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, which.ravel()


def row_bytes(rows: Floats) -> list[bytes]:
    """Every row (m, k) as its bytes: equal where all of its bits are."""
    return [row.tobytes() for row in rows]


def product(a: Floats, b: Floats) -> Floats:
    """``a @ b``, for b (k, n) or (k,) and a (..., k); several times slower where both are large."""
    return np.einsum("...k,kn->...n", a, b) if b.ndim == 2 else np.einsum("...k,k->...", a, b)


def dot(a: Floats, b: Floats) -> float:
    """The inner product of two short vectors (k,)."""
    total = 0.0
    for x, y in zip(a.tolist(), b.tolist(), strict=True):
        total += x * y
    return total


def length(vector: Floats) -> float:
    """The Euclidean norm of a short vector (k,)."""
    return math.sqrt(dot(vector, vector))


def combine_costs(beta: float, omega: Cost, distance: Cost) -> Cost:
    """(1 - beta) omega + beta distance, eq. (finew): the trade-off that all costs of this planner are made by."""
    return (1.0 - beta) * omega + beta * distance


def lengths_of(path: Floats) -> Floats:
    """The lengths (k - 1,) of the segments of a ``path`` (k, n)."""
    return np.linalg.norm(np.diff(path, axis=0), axis=1)


def lengths_along(path: Floats) -> Floats:
    """How far (k,) each row of a ``path`` (k, n) is from its beginning, along it."""
    return cumulative_sums(lengths_of(path))


def parts_of(lengths: Floats, longest: float) -> Ints:
    """Into how many parts (m,) segments of ``lengths`` (m,) are cut so that none is longer than ``longest``."""
    return np.maximum(1, np.ceil(lengths / longest)).astype(np.int64)


def cut(path: Floats, parts: Ints, delta: Floats | None = None) -> Floats:
    """``path`` (k, n) with segment i cut into ``parts[i]`` equal ones; its own rows stay as they are, to the bit.

    Row ``parts[:i].sum()`` of the result is row i of ``path``. ``delta`` (k - 1, n): the motion along each segment,
    where that is not the difference of its ends, as for joints that turn past pi.
    """
    delta = np.diff(path, axis=0) if delta is None else delta
    segment = np.repeat(np.arange(len(parts)), parts)
    first = cumulative_sums(parts)
    number = np.arange(len(segment)) - first[segment]
    rows = path[segment] + (number / parts[segment])[:, None] * delta[segment]
    rows = np.concatenate([rows, path[-1:]])
    rows[first] = path
    return rows


def plain_numbers(what: str, values: Any, error: type[PlannerError] = ArrayError) -> Floats:
    """``values`` as float64, whatever their shape and size; ``error`` where they are no numbers."""
    try:
        given = np.asarray(values)
        if given.dtype.kind in "fiu" or (given.dtype.kind == "O" and not any(map(_is_text, given.flat))):
            return given.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):
        pass
    raise error(f"{what} is no array of numbers: give integers or floats.")


def numbers(
    what: str, values: Any, shape: Shape, error: type[PlannerError] = ArrayError, most: float = np.inf
) -> Floats:
    """``values`` as float64 of a ``shape``, finite and within ``most`` of 0; not copied where they are that already.

    Otherwise ``error``, in one sentence that names ``what`` they are. For arrays that enter a public function.
    """
    array = plain_numbers(what, values, error)
    alike = len(array.shape) == len(shape) and all(
        isinstance(wanted, str) or size == wanted for size, wanted in zip(array.shape, shape, strict=True)
    )
    if not alike:
        wanted = f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
        raise error(f"{what} has shape {array.shape}: give an array of shape {wanted}.")
    fits = np.isfinite(array) & (np.abs(array) <= most)
    if not fits.all():
        limit = "" if most == np.inf else f", no farther than {most:g} from 0"
        _refuse(what, array, fits, f"every number has to be finite{limit}", error)
    return array


def indices(what: str, values: Any, shape: Shape, count: int, error: type[PlannerError] = ArrayError) -> Ints:
    """``values`` as int64 of a ``shape``, from 0 to ``count`` - 1; otherwise as :func:`numbers`."""
    given = numbers(what, values, shape, error)
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


def is_placement(value: object) -> bool:
    """Whether ``value`` is an array (4, 4), or what NumPy takes for one, as ``pinocchio.SE3``; lists are not."""
    return hasattr(value, "__array__") and np.shape(value) == (4, 4)  # type: ignore[call-overload]


def _is_text(value: Any) -> bool:
    return isinstance(value, bool | str | bytes)  # NumPy makes numbers of true, and of "0_3"


def _refuse(what: str, array: Floats, fits: Bools, remedy: str, error: type[PlannerError]) -> NoReturn:
    at = tuple(int(k) for k in np.argwhere(~fits)[0])
    where = f"[{', '.join(map(str, at))}]" if at else ""
    raise error(f"{what}{where} is {array[at]:g}: {remedy}.")
