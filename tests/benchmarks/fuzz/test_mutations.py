"""Changes at random: the same for a seed, nearly always a change, and never of what was given."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from benchmarks.fuzz.mutations import as_json, mutated_bytes, mutated_text, mutated_tree, mutated_xml

TREE: dict[str, Any] = {"a": [1, 2, {"b": None}], "c": "d", "e": {"f": [0.5, 1.5]}}
XML = '<robot name="r"><link name="a"><origin xyz="0 0 1"/></link><link name="b"/></robot>'
TEXT = "name: a\nsize: [1.0, 2.5]\nradius: 3\n"
KINDS: dict[str, tuple[Any, Callable[[Any, np.random.Generator], Any]]] = {
    "bytes": (TEXT.encode(), mutated_bytes),
    "text": (TEXT, mutated_text),
    "tree": (TREE, mutated_tree),
    "xml": (XML, mutated_xml),
}


@pytest.mark.parametrize("name", KINDS)
def test_a_seed_makes_one_change_and_leaves_the_original(name: str) -> None:
    original, mutated = KINDS[name]
    before = copy.deepcopy(original)
    first, again = ([mutated(original, np.random.default_rng(seed)) for seed in range(60)] for _ in range(2))
    assert original == before
    assert list(map(repr, first)) == list(map(repr, again))
    plain = XML.encode() if name == "xml" else TEXT.encode() if name == "text" else original
    assert sum(changed != plain for changed in first) > 50
    assert len(set(map(repr, first))) > 40


def test_bytes_are_never_more_than_there_were() -> None:
    for seed in range(40):
        assert len(mutated_bytes(b"0123456789", np.random.default_rng(seed))) <= 10
    assert mutated_bytes(b"", np.random.default_rng(0)) == b""


def test_a_tree_stays_json_but_now_and_then_too_deep_to_read() -> None:
    ends = {"read": 0, "too deep": 0}
    for seed in range(200):
        data = as_json(mutated_tree(TREE, np.random.default_rng(seed)), np.random.default_rng(seed))
        try:
            json.loads(data)
            ends["read"] += 1
        except RecursionError:
            ends["too deep"] += 1
    assert ends["read"] > 150
    assert ends["too deep"] > 0
