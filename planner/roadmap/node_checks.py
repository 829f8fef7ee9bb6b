"""Every node looked at by the collision library itself, whatever our own code has proven of its edges."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Floats, Ints
from planner.collision.checker import CollisionChecker
from planner.roadmap.roadmap import LIBRARIES, Roadmap

_log = logging.getLogger(__name__)


def nobody(count: int) -> NDArray[np.int8]:
    """``checked_by`` of nodes that no library has looked at."""
    return np.zeros(count, dtype=np.int8)


def with_checked_nodes(roadmap: Roadmap, checker: CollisionChecker, first: int = 0) -> Roadmap:
    """The roadmap after the library of ``checker`` has looked at all nodes from ``first`` on that it had not.

    It is one query a state. What it refuses is left out with its edges, and the log says so: it contradicts a proof.
    """
    library, checked_by = LIBRARIES.index(checker.name), roadmap.checked_by.copy()
    open_ = first + np.flatnonzero(checked_by[first:] != library)
    if not len(open_):
        return roadmap
    refused = open_[_refused(checker, roadmap.nodes[open_])]
    checked_by[open_] = library
    looked = replace(roadmap, checked_by=checked_by)
    if not len(refused):
        return looked
    kept = np.ones(len(roadmap.nodes), dtype=bool)
    kept[refused] = False
    return looked.part(kept, np.ones(len(roadmap.edges), dtype=bool))


def _refused(checker: CollisionChecker, q: Floats) -> Ints:
    """The rows of configurations (n, dof) that the library does not find free; the log names what touches."""
    rows, begin = [], 0
    while (first := checker.first_contact(q[begin:])) is not None:
        row, contact = begin + first[0], first[1]
        how = contact.how(checker.world.margin)
        _log.warning("node left out: %s says that %s %s there, against the proofs", checker.name, contact, how)
        rows, begin = [*rows, row], row + 1
    return np.array(rows, dtype=np.int64)
