"""What a drawn panel holds: its labelled lines, their data, its axes' names."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure


def lines(axes: Any) -> dict[str, np.ndarray]:
    """The labelled lines of a panel: (2, n) data by label."""
    return {str(line.get_label()): data(line) for line in axes.get_lines()}


def data(line: Any) -> np.ndarray:
    """(2, n) what a line shows."""
    return np.array(line.get_data(), dtype=float)


def require_labels(figure: Figure) -> None:
    """Every panel names both axes, with units."""
    for axes in figure.axes:
        if axes.axison and axes.get_label() != "<colorbar>":
            assert "(" in axes.get_xlabel() or axes.get_shared_x_axes().get_siblings(axes) != [axes], axes
            assert "(" in axes.get_ylabel() or "relative" in axes.get_ylabel(), axes.get_ylabel()
