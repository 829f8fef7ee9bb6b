"""Verdicts on sentences: of the paper, and of the benchmarks' aims."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Verdict:
    """A sentence, the number of cases that confirmed it, the number of cases, and a note with the measured values."""

    sentence: str
    confirmed: int
    of: int
    note: str

    @property
    def holds(self) -> bool:
        """True if there was a case and every case confirmed the sentence."""
        return 0 < self.of == self.confirmed


def tally(sentence: str, cases: Iterable[bool], note: str) -> Verdict:
    """A verdict from one truth value per case."""
    held = [bool(case) for case in cases]
    return Verdict(sentence, sum(held), len(held), note)
