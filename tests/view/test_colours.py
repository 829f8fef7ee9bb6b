"""The ramp: its lightness rises evenly, and both of its spellings are the same colours."""

import re

import numpy as np

from planner.view.surfaces import css_gradient, hex_colour, ramp_stops


def lightness(rgb: np.ndarray) -> np.ndarray:
    """CIE L*, from sRGB."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    y = linear @ [0.2126, 0.7152, 0.0722]
    return np.where(y > 0.008856, 116 * np.cbrt(y) - 16, 903.3 * y)


def test_order_survives_a_print_in_grey() -> None:
    steps = np.diff(lightness(np.array(ramp_stops())))
    assert steps.min() > 0
    assert steps.max() < 2.5 * steps.min()


def test_both_spellings_are_the_same_colours() -> None:
    named = [int(text, 16) for text in re.findall(r"#([0-9a-f]{6})", css_gradient())]
    assert named == [hex_colour(np.array(stop)) for stop in ramp_stops()]
    assert hex_colour((1.0, 0.5, 0.0, 0.2)) == 0xFF8000
