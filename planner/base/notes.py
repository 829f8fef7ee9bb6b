"""What a user is told of an input before a plan is believed: what makes little sense, what was passed over."""

from __future__ import annotations

import logging
from dataclasses import dataclass

LOGGER = "planner.notes"  # the command line prints what it logs


@dataclass(frozen=True)
class Note:
    """A sentence about a model or a file; ``grave`` where a plan may well be wrong because of it."""

    text: str
    grave: bool = True


def tell(*notes: str) -> None:
    """Log notes that a result holds too: at DEBUG, as a library's caller reads them there."""
    for note in notes:
        logging.getLogger(LOGGER).debug("%s", note)
