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
        data = _array_bytes(value) if isinstance(value, np.ndarray) else repr(value).encode()
        digest.update(len(data).to_bytes(8, "little") + data)
    return digest.hexdigest()


def _array_bytes(array: np.ndarray) -> bytes:
    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    return repr((little.dtype.str, little.shape)).encode() + little.tobytes()
