"""COLLADA files looked through before Assimp reads them.

An index that is no number makes it fill all memory, and so do thirty nodes that are each twice in the next one.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from planner.base.errors import choices
from planner.base.notes import Note
from planner.base.words import number
from planner.base.yamlfile import shown
from planner.models.files.urdf_rules import floats

_DEEPEST = 200  # levels of elements
_WHOLE = ("p", "vcount", "v", "h")  # elements that hold whole numbers
_INSTANCES = {"instance_node": "url", "instance_geometry": "url", "instance_controller": "url", "skin": "source"}
_HOLDERS = ("node", "mesh", "triangles", "polylist", "polygons", "trifans", "tristrips", "ph")  # of what is drawn
_MOST = 30_000_000  # indices, of positions, normals and colours: two million triangles have fewer
_HEAD = 1 << 16  # bytes in which a file says its unit and axis
_ASSET_ENDS = b"</asset>"
_UNIT = re.compile(rb"<unit\b[^>]*?\bmeter\s*=\s*[\"']([^\"'<>]{1,40})")
_AXIS = re.compile(rb"<up_axis>\s*([XY]_UP)\b")
_NOT_READ = ("skew", "convex_mesh", "spline", "brep")  # elements that place things, or hold them
_UNIT_LENGTH = 1e-3  # by how much an axis may miss it: a reader would scale by it
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
            return _scene_fault(root)
    return f"nests elements more than {_DEEPEST} deep"


def dae_notes(files: Iterable[Path]) -> Iterator[Note]:
    """What the COLLADA files among ``files`` say of their unit and axis, which is not followed.

    Nor do MoveIt and most readers of URDF: numbers count as they stand, times what scale the URDF or the scene gives.
    """
    turned: list[str] = []
    for path in dict.fromkeys(files):
        if path.suffix.lower() != ".dae":
            continue
        try:
            with path.open("rb") as file:
                head = file.read(_HEAD)
                if _ASSET_ENDS not in head:  # its comments are long
                    head += file.read()
        except OSError:  # who reads its triangles says so
            continue
        unit, axis = _UNIT.search(head), _AXIS.search(head)
        metres = unit[1].decode(errors="replace") if unit else "1"
        if [abs(value - 1.0) <= 1e-9 for value in floats(metres)] != [True]:
            text = f"mesh file {path} says that its unit is {shown(metres)} m, which is not followed: its numbers are "
            yield Note(f"{text}metres, unless its 'scale' makes them so; give it that, or export the file in metres.")
        turned += [path.name] if axis else []
    if turned:
        text = f"an up_axis other than Z_UP is not followed, as in MoveIt: of {choices(turned)} z stays z."
        yield Note(text, grave=False)


def _scene_fault(root: ET.Element) -> str | None:
    """No scene holds more than a mesh may, or nests deeper, once every instance is what it is an instance of."""
    known = {f"#{element.get('id')}": element for element in root.iter() if element.get("id")}
    sizes: dict[str, tuple[int, int]] = {}
    for scene in root.iter():
        if _name(scene) == "visual_scene":
            size, height = _unfolded(scene, known, sizes, 0)
            if height > _DEEPEST:
                return f"nests nodes more than {_DEEPEST} deep"
            if size > _MOST:
                return f"has instances that unfold to {size} nodes and indices, more than {_MOST}"
    for instance in root.iter():
        url = instance.get(_INSTANCES.get(_name(instance), ""))
        if url is not None and url not in known:
            return f"has a <{_name(instance)}> of {shown(url)}, which is not in it"
    return None


def _unfolded(
    element: ET.Element, known: Mapping[str, ET.Element], sizes: dict[str, tuple[int, int]], depth: int
) -> tuple[int, int]:
    """How many nodes and indices an element comes to with all instances below it, and how many levels.

    ``known`` by its URL; ``sizes``: what has been found out of these.
    """
    size, height = 1, 1
    for child in element if depth <= _DEEPEST else ():  # what contains itself has no end
        name, found = _name(child), (0, 0)
        if name == "p":
            found = len((child.text or "").split()), 0
        elif name in _INSTANCES:
            url = child.get(_INSTANCES[name], "")
            if url not in sizes and url in known:
                sizes[url] = _unfolded(known[url], known, sizes, depth + 1)
            found = sizes.get(url, (1, 1))
        elif name in _HOLDERS:
            found = _unfolded(child, known, sizes, depth + 1)
        size, height = size + found[0], max(height, found[1] + 1)
    return size, height if depth <= _DEEPEST else _DEEPEST + 1


def _name(element: ET.Element) -> str:
    return element.tag.rpartition("}")[2]


def _element_fault(element: ET.Element, most: int) -> str | None:
    """No count and no index is larger than the file itself: ``most`` bytes."""
    name, text = _name(element), element.text or ""
    if name in _WHOLE and not _are_counts(text.split(), most):
        return f"has a <{name}> that holds more than whole numbers"
    if name == "float_array" and not _are_numbers(text):
        return "has a <float_array> that holds more than numbers"
    if name in _NOT_READ:
        return f"has a <{name}>, which is not read"
    if name == "rotate" and abs(math.hypot(*list(floats(text))[:3]) - 1.0) > _UNIT_LENGTH:
        return f"has a <rotate> about {shown(text.strip())}, whose axis is not of length 1"
    for attribute in _COUNTS:
        value = element.get(attribute)
        if value is not None and name != "node" and not _is_count(value, most):
            return f"has {attribute}='{value[:20]}' in a <{name[:40]}>"
    return None


def _is_count(word: str, most: int) -> bool:
    return word.isascii() and word.isdecimal() and len(word) < 12 and int(word) <= most


def _are_counts(words: Sequence[str], most: int) -> bool:
    if not words:
        return True
    longest, together = max(map(len, words)), "".join(words)
    if longest > len(str(most)) or not together.isascii() or not together.isdecimal():
        return False
    return longest < len(str(most)) or max(map(int, words)) <= most


def _are_numbers(text: str) -> bool:
    try:
        return all(True for _ in map(number, text.split()))
    except ValueError:
        return False
