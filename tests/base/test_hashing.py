"""Hashes tell different contents apart and are the same for the same numbers on every machine."""

from __future__ import annotations

import numpy as np

from planner.base.hashing import content_hash


def test_the_same_numbers_have_the_same_hash_however_they_lie_in_memory() -> None:
    a = np.arange(12.0).reshape(3, 4)
    same = (a.astype(">f8"), np.asfortranarray(a), np.arange(24.0)[::2].reshape(3, 4) / 2)
    assert {content_hash([other]) for other in same} == {content_hash([a])}


def test_what_differs_hashes_otherwise() -> None:
    a = np.arange(12.0)
    contents = ([a], [a.reshape(3, 4)], [a.astype(np.float32)], [a.astype(np.int64)], [a[:6], a[6:]], [a, ""], [a + 0j])
    texts = (["ab", "c"], ["a", "bc"], ["abc"], [1], [1.0], ["1"], [1, 23], [12, 3])
    hashes = [content_hash(values) for values in (*contents, *texts)]
    assert len(set(hashes)) == len(hashes)
    assert content_hash([np.array([0.0])]) != content_hash([np.array([-0.0])])
