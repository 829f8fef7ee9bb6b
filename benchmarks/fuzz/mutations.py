"""Valid files made invalid, or only unusual: mostly by changing their structure, as parsers refuse changed bytes.

Everything is drawn from one generator, so that a case can be made again from its seed and number.
"""

from __future__ import annotations

import copy
import functools
import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from typing import Any

import numpy as np

_DEEP = 3000  # levels
_NUMBERS = (0, -1, 1e-320, 1e-9, -0.0, 1e20, -1e20, 1e300, 1e308, 10**25, 2**31, -(2**63), 90, 0.5, 999999999)
_TEXTS = ("", " ", "universe", "a" * 5000, "\u202e\u0000x", "ä\U0001f600", "q:1,2", "../../x", "%s{0}", "nan", "-inf")
_BOMB = functools.reduce(lambda inner, k: f"[&b{k} {inner}, *b{k} ]", range(40), "1")  # 2^40 values in 500 letters
_TOKENS = (
    *(_BOMB, "{<<: [&m {a: 1}, *m ]}", "&c [{a: *c }]", "&d {<<: *d }", "1" * 140_000, "1:" * 20_000 + "1"),
    *("nan", "inf", "-inf", "1e400", "-1e308", "1e-320", "0", "-1", "0x1F", "0b9", "9" * 5000, "1_0", "1:99", "٣", "²"),
    *(
        "~",
        "true",
        "[]",
        "{}",
        "!!int ''",
        "!!binary x",
        "!!set {a}",
        "&a [*a]",
        "<<: 1",
        "2001-13-45",
        ".nan",
        "? [a]",
    ),
    *('"\\ud800"', '"\\0"', "'", '"', "[" * 3000, "{a: " * 500, "<x>" * 3000, "&lt;", "<!ENTITY a 'b'>", "\t", "\r\n"),
)
_NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")


def mutated_text(text: str, rng: np.random.Generator) -> bytes:
    """One or two small changes to a text: numbers, words, lines, or bytes."""
    content = text
    for _ in range(int(rng.integers(1, 3))):
        content = _one_change(content, rng)
    data = content.encode("utf-8", errors="surrogatepass")
    return mutated_bytes(data, rng) if rng.random() < 0.1 else data


def _one_change(text: str, rng: np.random.Generator) -> str:
    numbers, lines = list(_NUMBER.finditer(text)), text.split("\n")
    token = _TOKENS[int(rng.integers(len(_TOKENS)))]
    match int(rng.integers(6)):
        case 0 | 1 if numbers:
            found = numbers[int(rng.integers(len(numbers)))]
            return text[: found.start()] + token + text[found.end() :]
        case 2:
            del lines[int(rng.integers(len(lines)))]
            return "\n".join(lines)
        case 3:
            lines.insert(int(rng.integers(len(lines) + 1)), lines[int(rng.integers(len(lines)))])
            return "\n".join(lines)
        case 4:
            return text[: int(rng.integers(len(text) + 1))]
    at = int(rng.integers(len(text) + 1))
    return text[:at] + token + text[at:]


def mutated_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """A few bytes changed, or what follows some place cut off."""
    if not data or rng.random() < 0.3:
        return data[: int(rng.integers(len(data) + 1))]
    changed = bytearray(data)
    for at in rng.integers(len(data), size=int(rng.integers(1, 9))):
        changed[int(at)] = int(rng.choice([0, 1, 0x7F, 0x80, 0xFF, int(rng.integers(256))]))
    return bytes(changed)


def mutated_tree(data: Any, rng: np.random.Generator) -> Any:
    """Plain data with one to three places changed: dropped, doubled, of another type, huge, or nested deeply."""
    data = copy.deepcopy(data)
    for _ in range(int(rng.integers(1, 4))):
        places = list(_places(data))
        if not places:
            break
        holder, key = places[int(rng.integers(len(places)))]
        match int(rng.integers(6)):
            case 0:
                del holder[key]
            case 1 if isinstance(holder, list):
                holder.insert(key, copy.deepcopy(holder[key]))
            case 2:
                holder[key] = [holder[key]]
            case 3 if isinstance(holder, dict):
                holder[_TEXTS[int(rng.integers(len(_TEXTS)))]] = holder.pop(key)
            case 4 if isinstance(holder[key], list):
                holder[key] = holder[key] * int(rng.choice([0, 2, 300]))
            case _:
                holder[key] = _odd_value(rng)
    return data


def _places(data: Any) -> Iterator[tuple[Any, Any]]:
    """Every (holder, key) of nested lists and mappings."""
    keys = list(data) if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ()
    for key in keys:
        yield data, key
        yield from _places(data[key])


def _odd_value(rng: np.random.Generator) -> Any:
    match int(rng.integers(4)):
        case 0:
            return _TEXTS[int(rng.integers(len(_TEXTS)))]
        case 1:
            odd = (None, True, [], {}, [None], {"x": 1}, float("nan"), float("inf"), [[0, 0, 0]], {"x": {"y": 1}})
            return copy.deepcopy(odd[int(rng.integers(len(odd)))])
    return _NUMBERS[int(rng.integers(len(_NUMBERS)))]


def as_json(data: Any, rng: np.random.Generator) -> bytes:
    """Plain data as JSON, which is YAML too; now and then with a place nested thousands of levels deep."""
    text = json.dumps(data)
    if rng.random() < 0.03:
        at = text.rfind(":") + 1
        text = text[:at] + "[" * _DEEP + text[at:-1] + "]" * _DEEP + text[-1:]
    return text.encode()


def mutated_xml(text: str, rng: np.random.Generator) -> bytes:
    """An XML document with one to three elements or attributes changed."""
    root = ET.fromstring(text)
    for _ in range(int(rng.integers(1, 4))):
        holders = [element for element in root.iter() if len(element)]
        holder = holders[int(rng.integers(len(holders)))]
        at = int(rng.integers(len(holder)))
        child = holder[at]
        match int(rng.integers(6)):
            case 0:
                holder.remove(child)
            case 1:
                holder.insert(at, copy.deepcopy(child))
            case 2:
                child.tag = str(rng.choice(["box", "mesh", "capsule", "link", "joint", "x", "visual", "mimic"]))
            case _:
                _change_attribute(child, rng)
        if not len(root):
            break
    text = ET.tostring(root, encoding="unicode")
    if rng.random() < 0.05:  # as text: the library's own writer goes one call deeper per level
        at = text.rfind("</")
        text = text[:at] + "<x>" * _DEEP + "</x>" * _DEEP + text[at:]
    return text.encode()


def _change_attribute(element: ET.Element, rng: np.random.Generator) -> None:
    owners = [one for one in element.iter() if one.attrib]
    if not owners:
        element.set("xyz", "1 2")
        return
    owner = owners[int(rng.integers(len(owners)))]
    name = str(rng.choice(list(owner.attrib)))
    odd = [*_NUMBERS, "nan", "inf", "1 2", "1 2 3 4", "0 0 0", "1e300 0 0", "nan 0 0", "x", "", "9" * 400, "1,5 0 0"]
    match int(rng.integers(4)):
        case 0:
            del owner.attrib[name]
        case 1:
            owner.set(name, str(rng.choice(["universe", "a" * 5000, "ä\u202e", "no.stl", "package://a/b", "floating"])))
        case _:
            owner.set(name, str(odd[int(rng.integers(len(odd)))]))
