"""The style of every figure: sizes of a journal, distinct lines, headroom; imports matplotlib."""

from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from planner.view.surfaces import ramp_stops

COLUMN, PAGE = 3.5, 7.16  # inches: a column and the full width of a page of the IEEE's journals
DOTS = 150  # per inch, of a PNG and on a screen
SMALL = 7.0  # points: numbers at the axes, legends

DASHES = "-", (0, (5, 1.5)), (0, (5, 1, 1, 1)), (0, (1, 1.1)), (0, (8, 2, 2, 2)), (0, (3, 1, 1, 1, 1, 1)), (0, (9, 1.5))
SHADES = "#0b2545", "#b23a0e", "#3a7d44", "#8d6aa8", "#8a6d00", "#555555", "#1c7c9c"
MARKS = "o", "s", "^", "D", "v", "P", "X"
RAMP = LinearSegmentedColormap.from_list("ramp", ramp_stops())  # dark to light, in print too

_STYLE: Any = {
    **dict.fromkeys(("font.size", "axes.labelsize", "axes.titlesize", "figure.titlesize"), 8.0),
    **dict.fromkeys(("legend.fontsize", "legend.title_fontsize"), SMALL),
    **dict.fromkeys(("axes.linewidth", "grid.linewidth", "hatch.linewidth"), 0.5),
    **{"legend.frameon": False, "legend.handlelength": 3.6, "lines.linewidth": 1.2, "lines.markersize": 4.0},
    **{"figure.dpi": DOTS, "grid.color": "0.87"},
}
journal = rc_context(_STYLE)  # decorates a function that draws


class JournalFigure(Figure):
    """A figure whose PDF and PS files have TrueType fonts: journals refuse the default Type 3 fonts."""

    def savefig(self, *arguments: Any, **options: Any) -> None:
        """Save as matplotlib does."""
        with rc_context({"pdf.fonttype": 42, "ps.fonttype": 42}):
            super().savefig(*arguments, **options)


def sheet(width: float, height: float) -> JournalFigure:
    """Return an empty figure (inches) with constrained layout."""
    return JournalFigure(figsize=(width, height), layout="constrained")


def single(width: float, height: float, x: str = "", y: str = "") -> tuple[Figure, Axes]:
    """Return a figure (inches) of one panel, labelled as :func:`label_axes` does."""
    figure = sheet(width, height)
    return figure, label_axes(figure.add_subplot(), x, y)


def label_axes(axes: Axes, x: str = "", y: str = "", title: str = "") -> Axes:
    """Return the panel with the names of its axes, its title and a faint grid."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title)
    axes.grid()
    axes.tick_params(labelsize=SMALL, width=0.6, length=2.5)
    return axes


def stroke(k: int) -> dict[str, Any]:
    """Return the look of the k-th line of a figure; after seven they repeat."""
    return {"linestyle": DASHES[k % 7], "color": SHADES[k % 7]}


def stroke_with_markers(k: int, every: float | None = None, **more: Any) -> dict[str, Any]:
    """Return the k-th line's look with a marker at its points, or at one in ``every`` share of the panel."""
    apart = None if every is None else (every * (0.2 + 0.11 * (k % 7)), every)
    look = {"marker": MARKS[k % 7], "markerfacecolor": "white", "markeredgewidth": 0.8, "markevery": apart}
    return {**stroke(k), **look, **more}


def leave_headroom(axes: Axes, *more: float, bottom: float | None = None) -> None:
    """Set limits of y a tenth of their range beyond lines and ``more`` values.

    With ``bottom`` the axis begins there, or below it where a curve does.
    """
    values = np.concatenate([*(np.asarray(line.get_ydata(), float) for line in axes.get_lines()), more])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    low = low if bottom is None else min(low, bottom)
    margin = 0.1 * (high - low or abs(high) or 1.0)
    axes.set_ylim(low if low == bottom else low - margin, high + margin)
