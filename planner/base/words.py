"""Numbers as files write them."""

from __future__ import annotations


def number(word: str) -> float:
    """The number that a ``word`` says; ValueError for one that is none.

    What only Python takes for a number is none: other readers find 0 in 0_3, or 1 in 1_0, and stop.
    """
    if "_" in word or not word.isascii():
        raise ValueError(f"could not convert string to float: {word[:20]!r}")
    return float(word)
