"""pyroboplan's PRM, to be compared with where it is installed."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import os

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.collision.coal import CoalChecker
from planner.collision.world import World

_RADIUS = 2.0  # rad; with its default of 0.5 not one of 100 nodes of a 7-joint arm found a neighbour


def installed() -> bool:
    """Whether pyroboplan is there."""
    return importlib.util.find_spec("pyroboplan") is not None


class PyroboplanPrm:
    """A PRM with pyroboplan's defaults but for the linking radius, on the world's bodies and pairs, checked by coal."""

    def __init__(self, world: World, nodes: int, seed: int) -> None:
        module = importlib.import_module("pyroboplan.planning.prm")
        options = module.PRMPlannerOptions(
            max_neighbor_radius=_RADIUS, max_construction_nodes=nodes, construction_timeout=float("inf"), rng_seed=seed
        )
        self._prm = module.PRMPlanner(world.robot.model, CoalChecker(world).geometry_model, options)
        self._dof = world.robot.dof

    def build(self) -> None:
        """Sample and link until there are as many nodes as were asked for."""
        with _quiet():
            self._prm.construct_roadmap()

    def graph(self) -> tuple[Floats, Ints]:
        """Nodes (n, dof) and edges (m, 2)."""
        nodes = list(self._prm.graph.nodes)
        index = {id(node): k for k, node in enumerate(nodes)}
        pairs = [sorted((index[id(edge.nodeA)], index[id(edge.nodeB)])) for edge in self._prm.graph.edges]
        return np.array([node.q for node in nodes]), np.unique(np.array(pairs, dtype=np.int64).reshape(-1, 2), axis=0)

    def query(self, start: Floats, goal: Floats) -> Floats:
        """A path (k, dof) from ``start`` to ``goal``, empty where none was found."""
        with _quiet():
            self._prm.reset()
            path = self._prm.plan(start, goal)
        return np.zeros((0, self._dof)) if path is None else np.array(path)


@contextlib.contextmanager
def _quiet():
    """It prints what it could not connect."""
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        yield
