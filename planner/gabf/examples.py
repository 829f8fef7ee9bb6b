"""Networks that the paper's text describes, for demonstrations and tests."""

from __future__ import annotations

import numpy as np

from planner.gabf.kernels import NodeDependent
from planner.gabf.network import Network

_NINE_NODE_ARCS = [
    # node i reads node j over weight w, in the paper's numbering
    (2, 1, 1.0),
    (2, 5, 0.5),
    (3, 1, 1.0),
    (3, 4, -0.5),
    (4, 2, 1.0),
    (4, 3, 1.0),
    (4, 7, -2.0),
    (5, 2, 1.0),
    (5, 4, 2.0),
    (6, 8, 1.0),
    (6, 9, 5.0),
    (6, 5, 0.5),
    (7, 9, -1.5),
    (7, 8, 2.0),
    (8, 9, 1.0),
    (8, 6, 3.0),
]


def nine_node() -> Network:
    """The example of fig. (example1), with weights of our own that agree with everything the text says of it.

    Array index k is node k + 1. Sources 1 and 9 with x* = 1; x_4* = 7 through 2 or 3, so P(4) = {2, 3}; 6
    reaches 9 both directly and through 8 at x_6* = 7, so 6 is in F_2 and not in F_1; D(G) = 3. Some weights
    are negative, as the kernels read |b|; the figure itself is not part of the paper's source.
    """
    i, j, w = (np.array(column) for column in zip(*_NINE_NODE_ARCS, strict=True))
    return Network.from_arcs(
        i.astype(np.int64) - 1,
        j.astype(np.int64) - 1,
        w,
        sources=np.array([0, 8]),
        n_nodes=9,
        source_values=np.ones(2),
        kernel=NodeDependent(),
    )
