"""Tables as Markdown, and middles of columns with gaps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np


def markdown_table(header: Sequence[str], lines: Iterable[Sequence[Any]], texts: int = 1) -> list[str]:
    """Lines of a Markdown table; the first ``texts`` columns are texts, the others numbers, to three digits."""
    rule = [":---" if k < texts else "---:" for k in range(len(header))]
    rows = [[_cell(value).replace("|", "\\|").replace("\n", " ") for value in line] for line in lines]
    return ["| " + " | ".join(row) + " |" for row in (header, rule, *rows)]


def median(values: Iterable[float | None]) -> float | None:
    """The median of the values that there are; None where there are none."""
    return percentile(values, 50.0)


def percentile(values: Iterable[float | None], share: float) -> float | None:
    """The percentile (linear between two values) of the values that there are; None where there are none."""
    there = [value for value in values if value is not None]
    return float(np.percentile(there, share)) if there else None


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
