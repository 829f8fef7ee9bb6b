"""DAE files: what their reader would not survive is refused first."""

from __future__ import annotations

import pytest

from planner.world.dae import dae_fault

DAE = "<COLLADA><mesh><float_array count='3'>0 0 1</float_array><p>0 1 2</p></mesh></COLLADA>"


@pytest.mark.parametrize(
    "bad",
    [
        DAE.replace("<p>0", "<p>.nan"),  # Assimp allocates until there is nothing left
        DAE.replace("<p>0", "<p>-1"),
        DAE.replace("count='3'", "count='999999999'"),
        DAE.replace("0 0 1", "0 0 x"),
        DAE.replace("<mesh>", "<x>" * 300 + "</x>" * 300 + "<mesh>"),
        DAE[:30],
    ],
)
def test_a_dae_that_does_not_fit_never_reaches_its_reader(bad: str) -> None:
    assert dae_fault(DAE.encode()) is None
    assert dae_fault(bad.encode()) is not None
