"""COLLADA files looked through before Assimp reads them: an index that is no number makes it fill all memory."""

from __future__ import annotations

import xml.etree.ElementTree as ET

_DEEPEST = 200  # levels of elements
_WHOLE = ("p", "vcount", "v", "h")  # elements that hold whole numbers
_COUNTS = ("count", "stride", "offset", "set")  # attributes


def dae_fault(content: bytes) -> str | None:
    """What does not fit in a COLLADA file, as the words after its name; None where a parser can take it."""
    try:
        root = ET.fromstring(content)
    except (ET.ParseError, ValueError, LookupError) as error:
        return f"is not well-formed XML ({str(error)[:80]})"
    level = [root]
    for _ in range(_DEEPEST):
        wrong = next(filter(None, (_element_fault(element, len(content)) for element in level)), None)
        if wrong:
            return wrong
        level = [child for element in level for child in element]
        if not level:
            return None
    return f"nests elements more than {_DEEPEST} deep"


def _element_fault(element: ET.Element, most: int) -> str | None:
    """No count and no index is larger than the file itself: ``most`` bytes."""
    name, text = element.tag.rpartition("}")[2], element.text or ""
    if name in _WHOLE and not _are_counts(text, most):
        return f"has a <{name}> that holds more than whole numbers"
    if name == "float_array" and not _are_numbers(text):
        return "has a <float_array> that holds more than numbers"
    for attribute in _COUNTS:
        value = element.get(attribute)
        if value is not None and name != "node" and not _is_count(value, most):
            return f"has {attribute}='{value[:20]}' in a <{name[:40]}>"
    return None


def _is_count(word: str, most: int) -> bool:
    return word.isascii() and word.isdecimal() and len(word) < 12 and int(word) <= most


def _are_counts(text: str, most: int) -> bool:
    words = text.split()
    if not words:
        return True
    longest = max(map(len, words))
    if longest > len(str(most)) or not "".join(words).isascii() or not "".join(words).isdecimal():
        return False
    return longest < len(str(most)) or max(map(int, words)) <= most


def _are_numbers(text: str) -> bool:
    try:
        for _ in map(float, text.split()):
            pass
    except ValueError:
        return False
    return True
