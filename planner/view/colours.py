"""Numbers as colours: a ramp from dark blue to yellow that stays readable in grey and to the colour-blind."""

from __future__ import annotations

import numpy as np

from planner.base.arrays import Floats

# lightness rises evenly along the ramp, so order survives a black and white print
_STOPS = np.array([[0.16, 0.11, 0.33], [0.20, 0.32, 0.55], [0.13, 0.54, 0.55], [0.38, 0.74, 0.38], [0.98, 0.88, 0.22]])


def ramp_stops() -> list[list[float]]:
    """The ramp as red, green, blue in [0, 1] at evenly spaced places, straight lines between."""
    return _STOPS.tolist()


def css_gradient() -> str:
    """The ramp as a CSS gradient, for a legend."""
    stops = ", ".join("#" + "".join(f"{round(255 * c):02x}" for c in stop) for stop in _STOPS)
    return f"linear-gradient(to right, {stops})"


def hex_colour(rgb: tuple[float, ...] | Floats) -> int:
    """Red, green, blue in [0, 1] as the number 0xrrggbb."""
    red, green, blue = (round(255 * float(value)) for value in rgb[:3])
    return (red << 16) + (green << 8) + blue
