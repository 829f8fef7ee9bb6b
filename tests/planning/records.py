"""Records as files hold them, whole and spoilt."""

from __future__ import annotations

import copy
import json
from typing import Any

SMALL: dict[str, Any] = {"robot": "planar_2r", "scene": "empty", "nodes": 60}


def as_written(record: dict[str, Any]) -> dict[str, Any]:
    return json.loads(json.dumps(record))


def spoilt(record: dict[str, Any]) -> list[dict[str, Any]]:
    """The record without its roadmap, with a text for the seed, and with a path of texts."""
    out = [copy.deepcopy(record) for _ in range(3)]
    del out[0]["roadmap"]
    out[1]["seed"] = "zero"
    out[2]["joints"] = [[1]]
    return out
