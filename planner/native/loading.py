"""The door to the compiled library: its functions with the types of their arguments, and arrays as they read them.

Every call leaves other Python threads running. The library keeps nothing that can change between two calls, but for
glances, which one thread asks: all else that is made here may be asked by several threads at once. It is given
addresses and believes the lengths of arrays, so whoever calls it checks these, by :func:`floats` and its like; numbers
and indices it checks itself, and refuses.
"""

from __future__ import annotations

import ctypes
import os
import threading
import weakref
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import ArrayError, InstallationError
from planner.base.interrupts import stop_requests

_VERSION = 35  # of the functions' arguments: what planner_version() says
_NAME = "libplanner.so"
_Pointer = ctypes.c_void_p
_int, _long, _double = ctypes.c_int, ctypes.c_int64, ctypes.c_double

# arguments of every function; these return nothing
_CHARGE = (_Pointer, _int, _Pointer, _int, _Pointer, *3 * [_int], _Pointer, _int)  # a chain, what it charges, threads
_PROVING = (*4 * [_Pointer], _double)  # a world, its bounds, the room of proofs
_ARGUMENTS: dict[str, Sequence[Any]] = {
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
        _double,
        *3 * [_Pointer],
        _int,
        _int,
        *2 * [_Pointer],
    ),
    "chain_manipulability": (_Pointer, _int, *2 * [_Pointer], _int, _Pointer, _int, _Pointer, _int, _int, _Pointer),
    "chain_motion_costs": (*_CHARGE, _int, *3 * [_Pointer]),
    "path_descend": (
        *_PROVING,
        *_CHARGE,
        *(_int, _Pointer, _int, _int, _Pointer, _double, _double, _Pointer, _Pointer),
        *2 * [_int, _Pointer],
        *(_int, *3 * [_Pointer]),
    ),
    "path_even_stretches": (
        *_PROVING,
        *_CHARGE,
        *(_int, _Pointer, _int, _int, *3 * [_Pointer], _double, _int, _int, *3 * [_Pointer]),
    ),
    "keeping_slack": (_Pointer, _int, _int, *3 * [_Pointer]),
    "keeping_project": (_Pointer, _int, *2 * [_Pointer], _double, _int, _int, _Pointer),
    "keeping_prove": (_Pointer, _int, _int, *6 * [_Pointer], *2 * [_double], _int, _Pointer),
    "world_add_spheres": (_Pointer, _int, _int, *2 * [_Pointer]),
    "world_add_target": (_Pointer, _int, _int, *3 * [_Pointer], _double),
    "world_set_motion": (_Pointer, _int, _int, *6 * [_Pointer], _double),
    "world_set_speed_limit": (_Pointer, _int, _double),
    "world_set_travel": (_Pointer, _Pointer),
    "world_set_pairs": (_Pointer, _int, *2 * [_Pointer]),
    "world_coarse": (_Pointer, _int, *3 * [_Pointer]),
    "world_close": (_Pointer, _int, *2 * [_Pointer], _int, *3 * [_Pointer], _int, *2 * [_Pointer]),
    "world_prove": (_Pointer, *5 * [_Pointer], _int, _int, _double, _int, *5 * [_Pointer]),
    "world_prove_together": (_Pointer, *5 * [_Pointer], _int, _int, _double, *3 * [_Pointer]),
    "gate_check": (_Pointer, *3 * [_int], _Pointer, _int, *2 * [_Pointer]),
    "stops_quickest": (_int, _int, _Pointer, _int, *7 * [_Pointer]),
    "world_first_proven": (
        _Pointer,
        *4 * [_Pointer],
        _int,
        _int,
        *2 * [_int, _Pointer],
        _double,
        _int,
        *3 * [_Pointer],
    ),
    "polynomials_extrema": (_long, _int, _int, *3 * [_Pointer]),
    "manipulability_costs": (_long, _Pointer, *3 * [_double], _int, _Pointer),
    "manipulability_cost_sums": (_long, _int, *2 * [_Pointer], *3 * [_double], _int, _Pointer),
    "arcs_step": (*2 * [_Pointer], _long, _Pointer, _long, *2 * [_Pointer], *3 * [_double], _int, _Pointer),
    "arcs_standing": (_Pointer, _long, _Pointer, _long, _Pointer, _int, *2 * [_Pointer]),
    "arcs_hops": (_long, _Pointer, _long, _Pointer, _long, *2 * [_Pointer]),
    "arcs_parent_values": (_Pointer, _long, _Pointer, _long, _Pointer, _int, _Pointer),
    "flow_moved": (_Pointer, _int, _long, _Pointer, _double, _int, _Pointer),
    "flow_sketch": (_Pointer, _long, _Pointer, _long, *2 * [_Pointer], _double, _int, _Pointer),
    "graph_costs": (_int, _int, *2 * [_Pointer], _int, *3 * [_Pointer]),
    "graph_detours": (_int, _int, *2 * [_Pointer], _int, *2 * [_Pointer], _int, _Pointer),
}
# what is given back, by chain_free() and so on
_FREED = ("chain", "boxes", "keeping", "world", "glance", "gate", "arcs")
_RESULTS: dict[str, tuple[Any, Sequence[Any]]] = {
    "planner_version": (_int, ()),
    "chain_new": (_Pointer, (_int, _int, *9 * [_Pointer])),
    "world_new": (_Pointer, (_Pointer, _double)),
    "world_add": (_int, (_Pointer, _int, _int, _int, _Pointer, _double, _int, _Pointer, _double)),
    "world_take": (_int, (_Pointer, _Pointer, _int)),
    "boxes_new": (_Pointer, (_Pointer, _int, *7 * [_Pointer])),
    "keeping_new": (_Pointer, (_Pointer, _int, *13 * [_Pointer])),
    "boxes_hits": (_long, (_Pointer, _int, _Pointer, _long, *2 * [_Pointer])),
    "graph_cheapest": (_int, (_int, _int, *2 * [_Pointer], *2 * [_int, _Pointer], *2 * [_Pointer])),
    "arcs_new": (_Pointer, (_long, _long, *4 * [_Pointer])),
    "flow_advance": (_double, (_Pointer, _long, _Pointer, _long, *3 * [_Pointer], _double, _double, _int, _Pointer)),
    "gate_new": (
        _Pointer,
        (*5 * [_Pointer], _int, _double, _int, *6 * [_Pointer], _int, _Pointer, *2 * [_double]),
    ),
    "chunk_curves": (_int, (*4 * [_int], *8 * [_Pointer])),
    "polynomials_worst": (_double, (_long, *3 * [_int], *3 * [_Pointer], _double, _Pointer)),
    "curve_phases": (_int, (_int, _int, *6 * [_Pointer])),
    "curve_knots": (_int, (_int, _int, *2 * [_Pointer], _int, _Pointer, _double, _long, _long, *4 * [_Pointer])),
    "motion_mean": (_int, (_int, _int, *3 * [_Pointer], _long, _long, *4 * [_Pointer])),
    "ramp_quickest": (_int, (_int, *4 * [_Pointer], _int, *4 * [_Pointer])),
    "motion_shares": (_int, (_int, _int, *6 * [_Pointer])),
    "curve_chords": (_int, (_int, _int, _Pointer, _int, _double, *2 * [_Pointer])),
    "world_next_ramp": (
        _int,
        (*4 * [_Pointer], _double, *3 * [_int, _Pointer], _int, *8 * [_Pointer]),
    ),
    "world_first_near": (_int, (_Pointer, _int, _Pointer)),
    "glance_new": (_Pointer, (_Pointer,)),
    "glance_looks_free": (_int, (_Pointer, *4 * [_Pointer], _double)),
    "world_tree_path": (
        _int,
        (*6 * [_Pointer], _int, _Pointer, _int, _Pointer, _int, _Pointer, _int, _Pointer, _long, _int, *2 * [_Pointer]),
    ),
    "world_parts": (_int, (*3 * [_Pointer], _int, _int, _double, _Pointer)),
    "world_walk": (_int, (*4 * [_Pointer], _int, _int, _Pointer, _int, _Pointer, _Pointer)),
    "world_cheapest_chain": (_int, (_Pointer, *3 * [_Pointer], _int, *2 * [_Pointer], _double, _int, *3 * [_Pointer])),
}


def threads() -> int:
    """How many threads work is shared among; the results are the same for any number."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def load(path: Path) -> ctypes.CDLL:
    """The library of a file, its functions with their types; :class:`InstallationError` for one that does not fit."""
    remedy = "install the package again ('make' or 'pip install .'), which compiles it."
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise InstallationError(f"the compiled library {path} cannot be loaded ({error}): {remedy}") from None
    try:
        if library.planner_version() == _VERSION:
            return _typed(library)
    except AttributeError:  # it lacks a function
        pass
    raise InstallationError(f"the compiled library {path} is of another version of the planner: {remedy}")


def _typed(library: ctypes.CDLL) -> ctypes.CDLL:
    """The library with the types of its functions; AttributeError where it lacks one."""
    library.planner_refusal.restype = ctypes.c_char_p
    library.planner_ask.argtypes, library.planner_ask.restype = (type(_ask), ctypes.c_uint64), None
    library.planner_ask(_ask, threading.main_thread().ident)
    for name in _FREED:
        function = getattr(library, f"{name}_free")
        function.argtypes, function.restype = (_Pointer,), None
    answering = {name: (_int, arguments) for name, arguments in _ARGUMENTS.items()} | _RESULTS
    for name, (result, arguments) in answering.items():
        function = getattr(library, name)
        function.argtypes, function.restype, function.errcheck = arguments, result, _refusing(library)
    return library


def given_back(owner: object, free: Callable[[int], None], handle: int) -> None:
    """Let the library ``free`` what ``owner`` holds when that goes; not at the process's end, as daemon threads may be
    in a call with it then."""
    weakref.finalize(owner, free, handle).atexit = False


_GO_ON, _FINISH, _LEAVE = 0, 1, 2  # what a long call is told, see source/interrupts.hpp
_raised: list[BaseException] = []  # by a handler of a signal, in the call that the main thread is in


def _asked() -> Iterator[int]:
    """What a long call on the main thread is told each time it asks.

    Python runs the handlers of signals as it comes back here, within the ``try``: a function's first instruction,
    where they would run otherwise, is in none, and ctypes drops what is raised there.
    """
    told = _GO_ON
    while True:
        try:
            yield told
            told = _FINISH if any(request() for request in stop_requests) else _GO_ON
        except GeneratorExit:
            raise
        except BaseException as error:  # KeyboardInterrupt is one
            _raised.append(error)
            told = _LEAVE


_asking = _asked()
next(_asking)
_ask = ctypes.CFUNCTYPE(_int)(_asking.__next__)


def _refusing(library: ctypes.CDLL) -> Callable[[Any, Any, Any], Any]:
    def checked(result: Any, function: Any, arguments: Any) -> Any:
        if result is None or result < 0:  # no pointer, or -1
            if _raised and threading.current_thread() is threading.main_thread():
                raise _raised.pop()
            why = library.planner_refusal().decode()
            raise ArrayError(f"the compiled {function.__name__} refuses what it was given: {why}.")
        return result

    return checked


library = load(Path(__file__).parent / _NAME)


_contiguous = np.ascontiguousarray


def floats(array: Any, *shape: int) -> Floats:
    """float64 in C order; :class:`ArrayError` unless of ``shape``, where that is given."""
    found = _contiguous(array, np.float64)
    return found if not shape or found.shape == shape else _refuse(found, shape)


def ints(array: Any, *shape: int) -> Ints:
    """int64 in C order; as :func:`floats`."""
    found = _contiguous(array, np.int64)
    return found if not shape or found.shape == shape else _refuse(found, shape)


def flags(array: Any, *shape: int) -> Any:
    """Bytes 0 and 1 in C order; as :func:`floats`."""
    found = _contiguous(array, np.uint8)
    return found if not shape or found.shape == shape else _refuse(found, shape)


def _refuse(found: Any, shape: tuple[int, ...]) -> NoReturn:
    raise ArrayError(f"an array of shape {found.shape} was given to the compiled library, which reads {shape}.")


def address(array: Any) -> int:
    """Where an array begins: what the library is given."""
    layout = array.flags
    if layout.writeable and layout.c_contiguous and array.size:
        return ctypes.addressof(ctypes.c_char.from_buffer(array))  # a quarter of the time
    return array.ctypes.data
