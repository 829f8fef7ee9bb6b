"""The door's types of every function are those of the C++: one mismatch would be memory written at random."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path

import pytest

from planner.native import loading

SOURCE = Path(loading.__file__).with_name("source")
KINDS = {"int": ctypes.c_int, "int64_t": ctypes.c_int64, "uint64_t": ctypes.c_uint64, "double": ctypes.c_double}
APART = {"planner_ask", "planner_refusal"}  # a function and a text: typed where they are looked up


def kind_of(declared: str) -> object:
    """The type of ctypes for a C++ type, without names: ``const double*``; None for ``void``."""
    return ctypes.c_void_p if declared.endswith("*") else None if declared == "void" else KINDS[declared]


def declared_in(text: str) -> dict[str, tuple[object, list[object]]]:
    """Result and arguments of every function that the text exports."""
    found: dict[str, tuple[object, list[object]]] = {}
    for block in re.findall(r'extern "C" \{\n(.*?)\n\}  // extern "C"', text, re.DOTALL):
        for result, name, inside in re.findall(r"^([A-Za-z][\w ]*\*?) ?\b(\w+)\(([^{]*)\) \{", block, re.MULTILINE):
            if name not in APART:
                types = [re.sub(r"\s*\w+$", "", one.strip()) for one in inside.split(",") if one.strip()]
                found[name] = kind_of(result.strip()), [kind_of(one.removeprefix("const ")) for one in types]
    return found


DECLARED = {
    name: types
    for path in (SOURCE / "library.cpp", *sorted((SOURCE / "calls").glob("*.hpp")))
    for name, types in declared_in(path.read_text()).items()
}


def test_the_door_knows_every_function_and_no_other() -> None:
    freed = {f"{name}_free" for name in loading._FREED}
    assert set(DECLARED) == {*loading._ARGUMENTS, *loading._RESULTS, *freed}
    assert all(DECLARED[name] == (None, [ctypes.c_void_p]) for name in freed)


@pytest.mark.parametrize("name", [*loading._ARGUMENTS, *loading._RESULTS])
def test_types_are_those_of_the_source(name: str) -> None:
    result, arguments = loading._RESULTS.get(name) or (ctypes.c_int, loading._ARGUMENTS[name])
    assert (result, list(arguments)) == DECLARED[name]


def test_a_mismatch_would_be_seen() -> None:
    one = 'extern "C" {\n\nint f(const World* world, int n, const int64_t* rows, double* out) {\n}\n\n}  // extern "C"'
    assert declared_in(one) == {"f": (ctypes.c_int, [ctypes.c_void_p, ctypes.c_int, *2 * [ctypes.c_void_p]])}
    assert declared_in(one.replace("int n", "int64_t n")) != declared_in(one)
    assert declared_in(one.replace("double* out", "double out")) != declared_in(one)
