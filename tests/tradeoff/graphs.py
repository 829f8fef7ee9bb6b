"""Small random graphs with two costs an arc, and what enumeration of all their simple paths says about them."""

import itertools
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from planner import gabf


@dataclass(frozen=True, eq=False)
class Graph:
    """Node i leads to ``heads[indptr[i]:indptr[i + 1]]`` at ``costs`` (n_arcs, 2)."""

    indptr: np.ndarray
    heads: np.ndarray
    costs: np.ndarray
    starts: np.ndarray
    goals: np.ndarray

    @property
    def nodes(self) -> int:
        return len(self.indptr) - 1

    def arcs_of(self, node: int) -> range:
        return range(self.indptr[node], self.indptr[node + 1])

    def cost(self, nodes: np.ndarray) -> np.ndarray:
        """(2,) what a node sequence costs; StopIteration where an arc is missing."""
        total = np.zeros(2)
        for i, j in itertools.pairwise(nodes):
            total += self.costs[next(arc for arc in self.arcs_of(i) if self.heads[arc] == j)]
        return total

    def network(self, beta: float = 0.5) -> gabf.Network:
        """The network of eq. (finew): the first cost of an arc is that of the node it leads to."""
        omega = np.ones(self.nodes)
        omega[self.heads] = self.costs[:, 0]
        kernel = gabf.TradeOff(beta)
        return gabf.Network(self.indptr, self.heads, self.costs[:, 1], self.goals, node_cost=omega, kernel=kernel)


def random_graph(seed: int, nodes: int, share: float, levels: int | None) -> Graph:
    """A long directed graph: ``share`` of all arcs between nodes up to three apart in a row, from one or two starts at
    one end to one or two goals at the other.

    The first cost belongs to the node that an arc leads to; the second is mostly low where the first is high. With
    ``levels`` they are so many multiples of 1/8, for many ties.
    """
    rng, row = np.random.default_rng(seed), np.arange(nodes)
    apart = np.abs(row[:, None] - row)
    tails, heads = np.nonzero((apart > 0) & (apart <= 3) & (rng.random((nodes, nodes)) < share))
    omega = rng.uniform(0.0, 1.0, nodes) ** 2
    costs = np.column_stack([omega[heads] + 0.02, (1.0 - omega[heads]) ** 2 + rng.uniform(0.01, 0.3, len(heads))])
    if levels is not None:
        costs = np.ceil(costs * levels / 1.3) / 8
    indptr = np.concatenate([[0], np.cumsum(np.bincount(tails, minlength=nodes))])
    return Graph(indptr, heads, costs, row[: 1 + nodes % 2], row[-1 - nodes // 2 % 2 :])


def simple_paths(graph: Graph) -> list[tuple[Fraction, Fraction]]:
    """The exact costs of every simple path from a start to the first goal it meets."""
    goals = set(graph.goals.tolist())
    costs = [(Fraction(a), Fraction(b)) for a, b in graph.costs.tolist()]
    found: list[tuple[Fraction, Fraction]] = []

    def walk(here: int, seen: frozenset[int], omega: Fraction, distance: Fraction) -> None:
        if here in goals:
            found.append((omega, distance))
            return
        for arc in graph.arcs_of(here):
            if (there := int(graph.heads[arc])) not in seen:
                walk(there, seen | {there}, omega + costs[arc][0], distance + costs[arc][1])

    for start in graph.starts.tolist():
        walk(start, frozenset([start]), Fraction(0), Fraction(0))
    return found


def enumerated_front(graph: Graph) -> list[tuple[Fraction, Fraction]]:
    """The non-dominated costs of all simple paths, ascending: quadratic, and as the definition says it."""
    points = sorted(set(simple_paths(graph)))
    return [p for p in points if not any(q != p and q[0] <= p[0] and q[1] <= p[1] for q in points)]


def enumerated_envelope(graph: Graph) -> tuple[list[tuple[Fraction, Fraction]], list[Fraction]]:
    """The lines that are lowest on more than one beta, in the order of beta, and the betas where one takes over.

    From all crossings of two lines: between two neighbouring ones a single line is lowest.
    """
    lines = enumerated_front(graph)
    crossings = {Fraction(0), Fraction(1)}
    for k, (a, b) in enumerate(lines):
        crossings |= {(c - a) / ((c - a) + (b - d)) for c, d in lines[k + 1 :]}
    betas = sorted(crossings)
    lowest = []
    for low, high in itertools.pairwise(betas):
        middle = (low + high) / 2
        lowest.append(min(lines, key=lambda line: (1 - middle) * line[0] + middle * line[1], default=None))
    kept = [k for k in range(len(lowest)) if lowest[k] is not None and (k == 0 or lowest[k] != lowest[k - 1])]
    return [lowest[k] for k in kept], [betas[k] for k in kept[1:]]
