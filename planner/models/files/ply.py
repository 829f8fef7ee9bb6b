"""PLY files looked through before Assimp reads them: of indices and counts that do not fit, it crashes."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from planner.base.words import number

_CODES = (
    {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H"}
    | {"int": "i", "int32": "i", "uint": "I", "uint32": "I"}
    | {"float": "f", "float32": "f", "double": "d", "float64": "d"}
)
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_LARGEST_HEADER = 1 << 16  # bytes
_MOST_PER_LIST = 1000  # corners of a face


@dataclass(frozen=True)
class _Property:
    name: str
    code: str
    count_code: str = ""  # of a list


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: tuple[_Property, ...]


def ply_fault(content: bytes) -> str | None:
    """What does not fit in a PLY file, as the words after its name; None where a parser has nothing to stumble over."""
    try:
        order, elements, body = _header(content)
        rows = _text_rows(elements, body) if not order else _binary_rows(elements, body, order)
        vertices = next((element.count for element in elements if element.name == "vertex"), 0)
        for index in rows:
            if not 0 <= index < vertices:
                return f"has a face of vertex {index}, and {vertices} vertices"
    except (ValueError, IndexError, KeyError, struct.error, UnicodeDecodeError) as error:
        return f"does not hold what its header says ({str(error)[:80]})"
    return None


def _header(content: bytes) -> tuple[str, list[_Element], bytes]:
    end = content[:_LARGEST_HEADER].index(b"end_header")
    body = content[end:].partition(b"\n")[2]
    lines = [line.split() for line in content[:end].decode("ascii").splitlines() if line.strip()]
    if lines[0] != ["ply"] or len(lines) < 2 or lines[1][0] != "format":
        raise ValueError("it does not begin as a PLY file")
    order, elements = _ORDERS[lines[1][1]], list[_Element]()
    for words in lines[2:]:
        match words:
            case ["comment" | "obj_info", *_]:
                pass
            case ["element", name, count]:
                elements.append(_Element(name, _count(count), ()))
            case ["property", "list", count_kind, kind, name] if elements:
                elements[-1] = _with(elements[-1], _Property(name, _CODES[kind], _CODES[count_kind]))
            case ["property", kind, name] if elements:
                elements[-1] = _with(elements[-1], _Property(name, _CODES[kind]))
            case _:
                raise ValueError(f"header line '{' '.join(words)}'")
    names = [element.name for element in elements]
    if len(set(names)) < len(names) or any(not element.properties for element in elements):
        raise ValueError("an element twice, or without properties")
    vertex = next((element for element in elements if element.name == "vertex"), _Element("", 0, ()))
    if sorted(p.name for p in vertex.properties if p.name in "xyz" and not p.count_code) != ["x", "y", "z"]:
        raise ValueError("no vertices with x, y and z")
    return order, elements, body


def _with(element: _Element, new: _Property) -> _Element:
    if new.name in [old.name for old in element.properties]:
        raise ValueError(f"property '{new.name}' twice")
    return _Element(element.name, element.count, (*element.properties, new))


def _count(word: str) -> int:
    if not (word.isascii() and word.isdecimal() and len(word) < 10):
        raise ValueError(f"count '{word[:20]}'")
    return int(word)


def _text_rows(elements: list[_Element], body: bytes) -> Iterator[int]:
    """Every vertex index of the faces; ValueError where a line does not fit."""
    lines = [line.split() for line in body.decode("ascii").splitlines() if line.strip()]
    if len(lines) != sum(element.count for element in elements):
        raise ValueError(f"{len(lines)} lines of values")
    at = 0
    for element in elements:
        for words in lines[at : at + element.count]:
            used = 0
            for item in element.properties:
                count = _length(_count(words[used])) if item.count_code else 1
                first = used + bool(item.count_code)
                used = first + count
                values = [number(word) for word in words[first:used]]
                if _is_index(element, item):
                    yield from map(int, words[first:used])
                if len(values) != count:
                    raise ValueError("a line that is too short")
            if used != len(words):
                raise ValueError(f"{len(words)} values in a line of '{element.name}'")
        at += element.count


def _binary_rows(elements: list[_Element], body: bytes, order: str) -> Iterator[int]:
    """As :func:`_text_rows`."""
    at = 0
    for element in elements:
        plain = order + "".join(item.code for item in element.properties)
        if not any(item.count_code for item in element.properties):
            at += struct.calcsize(plain) * element.count
            continue
        for _ in range(element.count):
            for item in element.properties:
                count = 1
                if item.count_code:
                    count = _length(struct.unpack_from(order + item.count_code, body, at)[0])
                    at += struct.calcsize(order + item.count_code)
                values = struct.unpack_from(f"{order}{count}{item.code}", body, at)
                at += struct.calcsize(f"{order}{count}{item.code}")
                if _is_index(element, item):
                    yield from values
    if at > len(body):
        raise ValueError(f"{len(body)} bytes of values, {at} expected")


def _is_index(element: _Element, item: _Property) -> bool:
    return element.name == "face" and bool(item.count_code) and item.code not in "fd"


def _length(count: int) -> int:
    if not 0 <= count <= _MOST_PER_LIST:
        raise ValueError(f"a list of {count} values")
    return int(count)
