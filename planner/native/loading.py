"""The door to the compiled library: its functions with the types of their arguments, and arrays as they read them.

Every call leaves other Python threads running.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import InstallationError

_VERSION = 13  # of the functions' arguments: what planner_version() says
_NAME = "libplanner.so"
_Pointer = ctypes.c_void_p
_int, _long, _double = ctypes.c_int, ctypes.c_int64, ctypes.c_double

# arguments of every function; all but those that make or count something return nothing
_ARGUMENTS: dict[str, Sequence[Any]] = {
    "chain_free": (_Pointer,),
    "chain_placements": (_Pointer, _int, *3 * [_Pointer]),
    "chain_points": (_Pointer, _int, _Pointer, _int, *2 * [_Pointer]),
    "chain_path_lengths": (_Pointer, _int, *3 * [_Pointer], _int, _Pointer, _int, _Pointer),
    "chain_inverse": (
        _Pointer,
        _int,
        _Pointer,
        _int,
        *4 * [_Pointer],
        _int,
        *3 * [_Pointer],
        _int,
        _int,
        *2 * [_Pointer],
    ),
    "boxes_free": (_Pointer,),
    "chain_manipulability": (_Pointer, _int, *2 * [_Pointer], _int, _Pointer, _int, _Pointer, _int, _int, _Pointer),
    "world_free": (_Pointer,),
    "world_add_spheres": (_Pointer, _int, _int, *2 * [_Pointer]),
    "world_add_target": (_Pointer, _int, _int, *3 * [_Pointer], _double),
    "world_set_motion": (_Pointer, _int, _int, *6 * [_Pointer]),
    "world_set_speed_limit": (_Pointer, _int, _double),
    "world_set_pairs": (_Pointer, _int, *2 * [_Pointer]),
    "world_coarse": (_Pointer, _int, *3 * [_Pointer]),
    "world_close": (_Pointer, _int, *2 * [_Pointer], _int, *3 * [_Pointer]),
    "world_prove": (_Pointer, *5 * [_Pointer], _int, _int, _double, _int, *5 * [_Pointer]),
    "world_first_proven": (_Pointer, *4 * [_Pointer], _int, *2 * [_Pointer], _double, _int, *3 * [_Pointer]),
    "curve_quickest": (_int, _int, *7 * [_Pointer]),
    "manipulability_costs": (_long, _Pointer, *3 * [_double], _int, _Pointer),
    "manipulability_cost_sums": (_long, _int, *2 * [_Pointer], *3 * [_double], _int, _Pointer),
    "arcs_free": (_Pointer,),
    "arcs_step": (*2 * [_Pointer], _long, _Pointer, *2 * [_long], *2 * [_Pointer], *3 * [_double], _int, _Pointer),
    "arcs_standing": (_Pointer, _long, _Pointer, _long, _Pointer, _int, *2 * [_Pointer]),
    "arcs_hops": (_long, *2 * [_Pointer], _long, *2 * [_Pointer]),
    "arcs_parent_values": (_Pointer, _long, *2 * [_Pointer], _int, _Pointer),
    "flow_moved": (_Pointer, _int, _long, _Pointer, _double, _int, _Pointer),
    "flow_sketch": (_Pointer, _long, *3 * [_Pointer], _double, _int, _Pointer),
    "graph_costs": (_int, _int, *2 * [_Pointer], _int, *3 * [_Pointer]),
    "graph_detours": (_int, _int, *2 * [_Pointer], _int, *2 * [_Pointer], _int, _Pointer),
}
_RESULTS: dict[str, tuple[Any, Sequence[Any]]] = {
    "planner_version": (_int, ()),
    "chain_new": (_Pointer, (_int, *6 * [_Pointer])),
    "world_new": (_Pointer, (_Pointer, _double)),
    "world_add": (_int, (_Pointer, _int, _int, _int, _Pointer, _double, _int, _Pointer)),
    "world_take": (_int, (_Pointer, _Pointer, _int)),
    "boxes_new": (_Pointer, (_Pointer, _int, *7 * [_Pointer])),
    "boxes_hits": (_long, (_Pointer, _int, _Pointer, _long, *2 * [_Pointer])),
    "graph_cheapest": (_int, (_int, _int, *2 * [_Pointer], *2 * [_int, _Pointer], _Pointer)),
    "arcs_new": (_Pointer, (_long, _long, *4 * [_Pointer])),
    "flow_advance": (_double, (_Pointer, _long, *4 * [_Pointer], _double, _double, _int, _Pointer)),
    "world_first_near": (_int, (_Pointer, _int, _Pointer)),
    "world_motion_looks_free": (_int, (_Pointer, *3 * [_Pointer], _int, _double)),
    "world_cheapest_chain": (_int, (_Pointer, *3 * [_Pointer], _int, *2 * [_Pointer], _double, *3 * [_Pointer])),
}


def threads() -> int:
    """How many threads work is shared among; the results are the same for any number."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _load() -> ctypes.CDLL:
    path = Path(__file__).parent / _NAME
    remedy = "install the package again ('make' or 'pip install .'), which compiles it."
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise InstallationError(f"the compiled library {path} cannot be loaded ({error}): {remedy}") from None
    for name, arguments in _ARGUMENTS.items():
        function = getattr(library, name)
        function.argtypes, function.restype = arguments, None
    for name, (result, arguments) in _RESULTS.items():
        function = getattr(library, name)
        function.argtypes, function.restype = arguments, result
    if library.planner_version() != _VERSION:
        raise InstallationError(f"the compiled library {path} is of another version of the planner: {remedy}")
    return library


library = _load()


def floats(array: Any) -> Floats:
    """float64 in C order."""
    return np.ascontiguousarray(array, dtype=np.float64)


def ints(array: Any) -> Ints:
    """int64 in C order."""
    return np.ascontiguousarray(array, dtype=np.int64)


def flags(array: Any) -> Any:
    """Bytes 0 and 1 in C order."""
    return np.ascontiguousarray(array, dtype=np.uint8)


def address(array: Any) -> int:
    """Where an array begins: what the library is given."""
    layout = array.flags
    if layout.writeable and layout.c_contiguous and array.size:
        return ctypes.addressof(ctypes.c_char.from_buffer(array))  # a quarter of the time
    return array.ctypes.data
