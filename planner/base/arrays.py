"""Array types, arithmetic on arrays and paths, and checks of the arrays that public functions take.

Docstrings that use the types give the shapes.

:func:`product`, :func:`dot` and :func:`length` have the same last bits on every processor that a plan promises them
for. NumPy leaves ``@`` and ``np.linalg`` to BLAS and LAPACK, which choose their code by the processor: eleven of twenty
kinds of products in planning differed between the AVX-512 and the AVX2 code of OpenBLAS, and one last bit can change
the roadmap. Sums of three terms use ``@``, as all code for FMA adds these in the same way.
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
"""A text stands for any size: ("n", 7)."""
Cost = TypeVar("Cost", float, Floats)

_ROUNDED = 1e-12  # of a rotation


def frozen(array: Any, dtype: Any = np.float64) -> NDArray[Any]:
    """Return a read-only, contiguous array of ``dtype``: a copy unless ``array`` is one already."""
    value = np.asarray(array)
    if value.dtype == dtype and value.flags.c_contiguous and not value.flags.writeable:
        return value
    result = np.array(array, dtype=dtype, order="C", copy=True)
    result.setflags(write=False)
    return result


def ranges(starts: Ints, counts: Ints) -> Ints:
    """Return starts[k], starts[k] + 1, ..., counts[k] numbers for each k in turn."""
    ends = np.cumsum(counts)
    return np.repeat(starts - (ends - counts), counts) + np.arange(counts.sum())


def cumulative_sums(values: Any) -> Any:
    """Return the sums (n + 1,) of the first 0, 1, 2, ... of ``values`` (n,)."""
    values = np.asarray(values)
    return np.concatenate([np.zeros(1, dtype=values.dtype), np.cumsum(values)])


def column_bounds(rows: Floats) -> tuple[Floats, Floats]:
    """Return the smallest and largest of each column of ``rows`` (n, k), 20 times as fast as along axis 0."""
    columns = [rows[:, k] for k in range(rows.shape[1])]
    return np.array([column.min() for column in columns]), np.array([column.max() for column in columns])


def distinct_rows(rows: NDArray[Any]) -> tuple[Ints, Ints]:
    """Return indices (m,) of the first of equal rows (n, k), sorted, and the group (n,) of each row."""
    _, first, which = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, which.ravel()


def row_bytes(rows: Floats) -> list[bytes]:
    """Return the bytes of each row (m, k): equal if and only if all bits are."""
    return [row.tobytes() for row in rows]


def product(a: Floats, b: Floats) -> Floats:
    """Return ``a @ b`` for a (..., k) and b (k, n) or (k,); several times slower if both are large."""
    return np.einsum("...k,kn->...n", a, b) if b.ndim == 2 else np.einsum("...k,k->...", a, b)


def dot(a: Floats, b: Floats) -> float:
    """Return the inner product of two short vectors (k,)."""
    total = 0.0
    for x, y in zip(a.tolist(), b.tolist(), strict=True):
        total += x * y
    return total


def length(vector: Floats) -> float:
    """Return the Euclidean norm of a short vector (k,)."""
    return math.sqrt(dot(vector, vector))


def combine_costs(beta: float, omega: Cost, distance: Cost) -> Cost:
    """Return (1 - beta) omega + beta distance, eq. (finew): the trade-off of all costs."""
    return (1.0 - beta) * omega + beta * distance


def lengths_of(path: Floats) -> Floats:
    """Return the lengths (k - 1,) of the segments of a ``path`` (k, n)."""
    return np.linalg.norm(np.diff(path, axis=0), axis=1)


def lengths_along(path: Floats) -> Floats:
    """Return the length (k,) along a ``path`` (k, n) from its start to each row."""
    return cumulative_sums(lengths_of(path))


def parts_of(lengths: Floats, longest: float) -> Ints:
    """Return the numbers of equal parts (m,) that cut ``lengths`` (m,) to at most ``longest`` each."""
    return np.maximum(1, np.ceil(lengths / longest)).astype(np.int64)


def cut(path: Floats, parts: Ints, delta: Floats | None = None) -> Floats:
    """Cut segment i of a ``path`` (k, n) into ``parts[i]`` equal ones; its rows keep their bits.

    Row ``parts[:i].sum()`` of the result is row i of ``path``. ``delta`` (k - 1, n) is the motion along each segment,
    by default the difference of its ends; joints that turn past pi need another one.
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
    """Return ``values`` as float64 of any shape; raise ``error`` unless they are numbers."""
    try:
        given = np.asarray(values)
        if given.dtype.kind in "fiu" or (given.dtype.kind == "O" and not any(map(_is_text, given.flat))):
            return given.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):
        pass
    raise error(f"{what} must be an array of numbers, got {type(values).__name__}: give integers or floats.")


def numbers(
    what: str, values: Any, shape: Shape, error: type[PlannerError] = ArrayError, most: float = np.inf
) -> Floats:
    """Return ``values`` as float64 of a ``shape``, finite and within ``most`` of 0, uncopied if possible.

    Raises ``error`` otherwise, with ``what`` as the name of the values. For arrays that enter a public function.
    """
    array = plain_numbers(what, values, error)
    is_alike = len(array.shape) == len(shape) and all(
        isinstance(wanted, str) or size == wanted for size, wanted in zip(array.shape, shape, strict=True)
    )
    if not is_alike:
        wanted = f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
        raise error(f"{what} must have shape {wanted}, got {array.shape}: give such an array.")
    fits = np.isfinite(array) & (np.abs(array) <= most)
    if not fits.all():
        limit = "" if most == np.inf else f" and within {most:g} of 0"
        _refuse(what, array, fits, f"finite{limit}", error)
    return array


def indices(what: str, values: Any, shape: Shape, count: int, error: type[PlannerError] = ArrayError) -> Ints:
    """Return ``values`` as int64 of a ``shape``, each from 0 to ``count`` - 1; raise as :func:`numbers`."""
    given = numbers(what, values, shape, error)
    fits = (given >= 0) & (given < count) & (given == np.floor(given))
    if not fits.all():
        _refuse(what, given, fits, f"a whole number from 0 to {count - 1}", error)
    return given.astype(np.int64)


def placement(what: str, values: Any, error: type[PlannerError] = ArrayError, most: float = np.inf) -> Floats:
    """Return ``values`` as a rigid placement (4, 4): rotation, position, last row 0 0 0 1.

    A rotation that is off by at most 1e-6, as by rounding, becomes the nearest one, because a placement must not scale
    a body. Raises as :func:`numbers`.
    """
    array = numbers(what, values, (4, 4), error, most)
    turn, last = array[:3, :3], np.array([0.0, 0.0, 0.0, 1.0])
    off = np.abs(turn @ turn.T - np.eye(3)).max()
    if off > 1e-6 or np.linalg.det(turn) <= 0 or np.abs(array[3] - last).max() > 1e-9:
        raise error(f"{what} must be a rigid (4, 4) placement: make it by planner.pose.")
    if off > _ROUNDED:
        left, _, right = np.linalg.svd(turn)
        array = frozen(np.vstack([np.column_stack([left @ right, array[:3, 3]]), last]))
    return array


def is_placement(value: object) -> bool:
    """Return whether ``value`` is an array (4, 4) or converts to one, as ``pinocchio.SE3``, not a list."""
    return hasattr(value, "__array__") and np.shape(value) == (4, 4)  # type: ignore[call-overload]


def _is_text(value: Any) -> bool:
    return isinstance(value, bool | str | bytes)  # NumPy would convert True and "0_3"


def _refuse(what: str, array: Floats, fits: Bools, rule: str, error: type[PlannerError]) -> NoReturn:
    at = tuple(int(k) for k in np.argwhere(~fits)[0])
    where = f"[{', '.join(map(str, at))}]" if at else ""
    raise error(f"{what}{where} must be {rule}, got {array[at]:g}.")
