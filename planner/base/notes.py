"""What a user is told of an input before a plan is believed: what makes little sense, what was passed over."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Note:
    """A sentence about a model or a file; ``grave`` where a plan may well be wrong because of it."""

    text: str
    grave: bool = True
