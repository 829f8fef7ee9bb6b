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
        if isinstance(value, np.ndarray):  # as it lies in memory: no copy of a large one
            little = np.ascontiguousarray(value, dtype=value.dtype.newbyteorder("<"))
            text = repr((little.dtype.str, little.shape)).encode()
            digest.update((len(text) + little.nbytes).to_bytes(8, "little") + text)
            digest.update(little.data)
        else:
            text = repr(value).encode()
            digest.update(len(text).to_bytes(8, "little") + text)
    return digest.hexdigest()
