"""Messages that several tests read."""

import copy
from pathlib import Path
from typing import Any

import yaml

from tests.documents import ROOT

HERE = Path("test.yaml")


BOX = {"id": "crate", "primitives": [{"type": "box", "dimensions": [0.1, 0.2, 0.3]}],
       "primitive_poses": [{"position": [1, 2, 3], "orientation": [0, 0, 0.5**0.5, 0.5**0.5]}]}  # fmt: skip


def scene(*objects: dict, **more: object) -> dict:
    return {"world": {"collision_objects": list(objects)}, **more}


EXAMPLES = ROOT / "scenes" / "examples"
SCENE = yaml.safe_load((EXAMPLES / "scene0001.yaml").read_text())
REQUEST = yaml.safe_load((EXAMPLES / "request0001.yaml").read_text())


def changed(message: dict, place: str, value: object) -> dict:
    """The message with another value at a path such as "goal_constraints.0.name"; missing parents are created."""
    found = copy.deepcopy(message)
    *above, last = place.split(".")
    here: Any = found
    for step in above:
        here = here[int(step)] if isinstance(here, list) else here.setdefault(step, {})
    here[int(last) if isinstance(here, list) else last] = copy.deepcopy(value)
    return found
