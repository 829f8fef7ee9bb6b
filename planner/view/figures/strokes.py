"""How figures look: faint grids, lines that stay apart in a black and white print. A door to matplotlib."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

DASHES = ("-", (0, (5, 1.5)), (0, (5, 1.2, 1, 1.2)), (0, (1, 1.1)), (0, (8, 2, 2, 2)), (0, (3, 1, 1, 1, 1, 1)))
SHADES = ("#0b2545", "#b23a0e", "#3a7d44", "#8d6aa8", "#8a6d00", "#555555")
MARKS = ("o", "s", "^", "D", "v", "P")


def stroke(k: int) -> dict[str, Any]:
    """The look of the k-th line of a figure; after six they repeat."""
    return {"linestyle": DASHES[k % 6], "color": SHADES[k % 6], "linewidth": 1.5}


def marked(k: int) -> dict[str, Any]:
    """The k-th line's look with a marker at its points."""
    return {**stroke(k), "marker": MARKS[k % 6], "markersize": 4.5, "markerfacecolor": "white"}


def single(width: float, height: float, x: str = "", y: str = "") -> tuple[Figure, Axes]:
    """A figure (inches) of one panel, named as :func:`labelled` does."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, labelled(figure.add_subplot(), x, y)


def labelled(axes: Axes, x: str = "", y: str = "", title: str = "") -> Axes:
    """The panel with the names of its axes, its title and a faint grid."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.25)
    return axes
