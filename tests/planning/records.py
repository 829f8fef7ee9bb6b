"""Records as files hold them, whole and spoilt."""

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


def unknown_keys(record: Any, schema: dict[str, Any]) -> list[str]:
    """The keys of a record that a schema does not name, at any depth."""

    def unknown(value: Any, part: dict[str, Any], where: str) -> list[str]:
        if "$ref" in part:
            part = schema["$defs"][part["$ref"].split("/")[-1]]
        for other in part.get("anyOf", []):
            if other.get("type") != "null":
                return unknown(value, other, where) if value is not None else []
        if isinstance(value, list):
            return [x for item in value for x in unknown(item, part.get("items", {}), where)]
        if not isinstance(value, dict) or "properties" not in part:
            return []
        known = part["properties"]
        inside = [x for k, item in value.items() if k in known for x in unknown(item, known[k], f"{where}.{k}")]
        return [f"{where}.{key}" for key in value if key not in known] + inside

    return unknown(record, schema, "plan")
