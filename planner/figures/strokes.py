"""Lines that stay apart in a black and white print: by dash and marker as well as by shade."""

from __future__ import annotations

from typing import Any

DASHES = ("-", (0, (5, 1.5)), (0, (5, 1.2, 1, 1.2)), (0, (1, 1.1)), (0, (8, 2, 2, 2)), (0, (3, 1, 1, 1, 1, 1)))
SHADES = ("#0b2545", "#b23a0e", "#3a7d44", "#8d6aa8", "#8a6d00", "#555555")
MARKS = ("o", "s", "^", "D", "v", "P")


def stroke(k: int) -> dict[str, Any]:
    """The look of the k-th line of a figure; after six they repeat."""
    return {"linestyle": DASHES[k % 6], "color": SHADES[k % 6], "linewidth": 1.5}


def marked(k: int) -> dict[str, Any]:
    """The k-th line's look with a marker at its points."""
    return {**stroke(k), "marker": MARKS[k % 6], "markersize": 4.5, "markerfacecolor": "white"}
