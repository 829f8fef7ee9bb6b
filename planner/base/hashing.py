"""Content hashes: the same numbers give the same hash on every machine."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from typing import Any

import numpy as np


def content_hash(values: Iterable[Any]) -> str:
    """SHA-256 (hex) over arrays (their dtype, shape and bytes) and plain values (their repr), in order."""
    digest = hashlib.sha256()
    for value in values:
        text, numbers = _parts(value)
        digest.update((len(text) + numbers.nbytes).to_bytes(8, "little") + text)
        digest.update(numbers.data)
    return digest.hexdigest()


def _parts(value: Any) -> tuple[bytes, np.ndarray]:
    """What stands before the numbers, and the numbers as they lie in memory: no copy of a large array."""
    if not isinstance(value, np.ndarray):
        return repr(value).encode(), np.empty(0)
    little = np.ascontiguousarray(value, dtype=value.dtype.newbyteorder("<"))
    return repr((little.dtype.str, little.shape)).encode(), little
