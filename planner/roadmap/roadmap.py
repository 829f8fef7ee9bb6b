"""The roadmap as immutable arrays, with the quantities that its costs are made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Bools, Floats, Ints, frozen
from planner.base.cache import content_hash
from planner.base.errors import StateError, require_extra
from planner.base.resolutions import W_STATES_PER_EDGE
from planner.base.resources import versions
from planner.collision.checker import CollisionChecker
from planner.collision.world import World
from planner.constraints.path_constraints import PathConstraints
from planner.cost.scale import COSTS, CostScale
from planner.kinematics.forward import Chain
from planner.problem.outcome import Record, html_table
from planner.robot.robot import Robot
from planner.robot.shapes import Body


@dataclass(frozen=True)
class Origin:
    """The robot and scene of a roadmap, and how it was grown; checked when it is loaded."""

    robot: str
    robot_identity: str
    scene: str
    scene_identity: str
    joints: tuple[str, ...]
    tool: str
    margin: float  # m
    seed: int
    versions: Mapping[str, str]
    lower: tuple[float, ...]  # joint limits, rad (m)
    upper: tuple[float, ...]
    world: str  # content_hash of everything that is checked


def record_origin(checker: CollisionChecker, seed: int) -> Origin:
    """Return the robot and scene of a roadmap grown with this checker."""
    world = checker.world
    return Origin(
        robot=world.robot.name,
        robot_identity=world.robot.identity,
        scene=world.scene.name,
        scene_identity=world.scene.identity,
        joints=world.robot.joints,
        tool=world.robot.tool_text,
        margin=world.margin,
        seed=seed,
        versions=versions(),
        lower=tuple(world.robot.lower.tolist()),
        upper=tuple(world.robot.upper.tolist()),
        world=world_hash(world),
    )


def world_hash(world: World) -> str:
    """Return a hash of kinematics, shapes and placements of bodies and obstacles, and checked pairs."""
    obstacles = [content for item in world.obstacles for content in (item.placement, *item.shape.content())]
    kinematics = _kinematics_hash(Chain.from_arm(world.robot))
    return content_hash([kinematics, *map(_body_hash, world.bodies), world.self_pairs, *obstacles, world.checked])


@lru_cache(maxsize=16)
def _kinematics_hash(chain: Chain) -> str:
    """Hash nine decimals: the arithmetic of another library changes further ones."""
    return content_hash(np.round(getattr(chain, item.name).astype(np.float64), 9) + 0.0 for item in fields(chain))


@lru_cache(maxsize=256)
def _body_hash(body: Body) -> str:
    """Hash a body; cached, as a session hashes after every change and detailed meshes take milliseconds."""
    return content_hash([body.joint, body.placement, *body.shape.content()])


@dataclass(frozen=True, kw_only=True, eq=False)
class RoadmapRecord(Record):
    """Size, proofs and hash of the roadmap."""

    nodes: int
    nodes_checked: dict[str, int]
    """how many nodes each collision library has found free"""
    edges: int
    """counted undirected"""
    components: int
    edges_certified: int
    """edges that are proven free"""
    edges_removed: int
    """edges that failed the second check"""
    sha256: str
    scale: CostScale

    @property
    def text(self) -> str:
        """The counts, and the libraries that checked the nodes."""
        counts = {name: count for name, count in self.nodes_checked.items() if count}
        parts = [f"{'each' if count == self.nodes else count} checked by {name}" for name, count in counts.items()]
        return f"{self.counts}; nodes: {', '.join(parts) or 'checked by no library'}"

    @property
    def counts(self) -> str:
        """The counts of nodes, edges and components."""
        proven = "all" if self.edges_certified == self.edges else f"{self.edges_certified} of them"
        components = f"{self.components} component{'s' if self.components != 1 else ''}"
        return f"{self.nodes} nodes, {self.edges} edges, {proven} proven free, {components}"


@dataclass(frozen=True, eq=False)
class Roadmap:
    """Configurations and the proven straight motions between them.

    ``nodes`` (n, dof) rad; ``edges`` (m, 2) node indices, first below second, sorted; ``proven`` (m,) whether a proof
    covers the whole edge. Indices of starts and goals come first. The costs consist of w (n,), joint length (m,) rad,
    length of the tool's path (m,) metres, and w at evenly spaced states of every edge (m, W_STATES_PER_EDGE);
    ``edge_cost`` (m, 3) is the mean of each of the ``COSTS`` along every edge, on ``scale``. An edge's certificate:
    ``clearance`` (m,) metres, a proven lower bound on every distance beyond the margin along it (0: no more is known,
    inf: there is nothing to touch), and ``samples`` (m,) configurations of its proof. Parts of a motion have the
    certificate of the whole motion. ``checked_by`` (n,) is the number in :data:`LIBRARIES` of the collision library
    that found the node free.
    """

    nodes: Floats
    edges: Ints
    proven: Bools
    starts: Ints
    goals: Ints
    manipulability: Floats
    joint_length: Floats
    tool_length: Floats
    edge_manipulability: Floats
    edge_cost: Floats
    clearance: Floats
    samples: Ints
    checked_by: NDArray[np.int8]
    scale: CostScale
    origin: Origin

    def __repr__(self) -> str:
        origin, size = self.origin, f"{len(self.nodes)} nodes, {len(self.edges)} edges"
        return f"<Roadmap: {origin.robot} in {origin.scene}, {size}>"

    def _repr_html_(self) -> str:
        w, length, origin = self.manipulability, self.joint_length, self.origin
        edges = f"mean {length.mean():.3f} rad, longest {length.max():.3f} rad" if len(length) else "none"
        rows = [
            ("size", self.record().text),
            ("starts, goals", f"{len(self.starts)}, {len(self.goals)}"),
            ("manipulability w", f"{w.min():.3g} to {w.max():.3g} at its nodes"),
            ("edges", edges),
            ("seed", str(origin.seed)),
        ]
        return html_table(f"Roadmap of {origin.robot} in {origin.scene}", rows)

    def record(self, edges_removed: int = 0) -> RoadmapRecord:
        """Return size, proofs and hash, and the number of edges that failed when they were proven again."""
        return RoadmapRecord(
            nodes=len(self.nodes),
            nodes_checked=self.nodes_checked,
            edges=len(self.edges),
            components=self.component_count,
            edges_certified=int(self.proven.sum()),
            edges_removed=edges_removed,
            sha256=self.sha256,
            scale=self.scale,
        )

    @property
    def nodes_checked(self) -> dict[str, int]:
        """The number of nodes that each library has found free."""
        return {name: int((self.checked_by == k).sum()) for k, name in enumerate(LIBRARIES) if k}

    def __post_init__(self) -> None:
        for name, dtype in DTYPES.items():
            object.__setattr__(self, name, frozen(getattr(self, name), dtype))

    @cached_property
    def components(self) -> Ints:
        """(n,) component number of each node; numbers increase in the order of the nodes."""
        return component_labels(len(self.nodes), self.edges)

    @property
    def component_count(self) -> int:
        return int(self.components.max(initial=-1)) + 1

    @property
    def is_connected(self) -> bool:
        """Whether some start and some goal lie in one component."""
        return bool(np.isin(self.components[self.starts], self.components[self.goals]).any())

    @cached_property
    def sha256(self) -> str:
        """A hash of the graph itself: configurations, edges, proofs, starts and goals."""
        arrays = [self.nodes, self.edges, self.proven, self.starts, self.goals]
        return content_hash([*arrays, self.origin.joints, self.origin.tool])

    def edge_index(self, i: int, j: int) -> int:
        """Return the row of the edge between two nodes; KeyError if there is none."""
        low, high = min(i, j), max(i, j)
        rows = np.nonzero((self.edges[:, 0] == low) & (self.edges[:, 1] == high))[0]
        if not len(rows):
            raise KeyError((i, j))
        return int(rows[0])

    def to_networkx(self) -> Any:
        """Return a ``networkx.Graph``: nodes with ``q`` (dof,) rad and ``manipulability``, edges with lengths.

            networkx.shortest_path(roadmap.to_networkx(), start, goal, weight="joint_length")

        Edges have ``joint_length`` (rad), ``tool_length`` (m), ``w_min``, the smallest sampled w, and ``certified``,
        whether they are proven free. :class:`InstallationError` without the extra ``interop``.
        """
        graph, least = require_extra("networkx", "interop").Graph(), self.edge_manipulability.min(axis=1)
        least = np.minimum(least, self.manipulability[self.edges].min(axis=1))
        for k, (q, w) in enumerate(zip(self.nodes, self.manipulability.tolist(), strict=True)):
            graph.add_node(k, q=q, manipulability=w)
        names = ("joint_length", "tool_length", "w_min", "certified")
        columns = self.joint_length, self.tool_length, least, self.proven
        for (i, j), *row in zip(self.edges.tolist(), *(column.tolist() for column in columns), strict=True):
            graph.add_edge(i, j, **dict(zip(names, row, strict=True)))
        return graph

    def without_edge(self, row: int) -> Roadmap:
        """Return the roadmap without one edge."""
        return self.part(np.ones(len(self.nodes), dtype=bool), np.arange(len(self.edges)) != row)

    def part(self, nodes: Bools, edges: Bools) -> Roadmap:
        """Return the roadmap of some ``nodes`` (n,) and some ``edges`` (m,) between them, renumbered in order."""
        edges = edges & nodes[self.edges].all(axis=1)
        number = np.cumsum(nodes) - 1
        arrays: dict[str, Any] = {name: getattr(self, name)[edges] for name in EDGE_ARRAYS}
        arrays |= {name: getattr(self, name)[nodes] for name in NODE_ARRAYS}
        arrays |= {name: number[rows[nodes[rows]]] for name, rows in (("starts", self.starts), ("goals", self.goals))}
        return replace(self, **arrays | {"edges": number[arrays["edges"]]})


LIBRARIES = ("none", "fcl", "coal")
ARRAYS: dict[str, tuple[Any, str, tuple[int | str, ...]]] = {
    # dtype, the item of a row, and the shape of a row
    "nodes": (np.float64, "node", ("dof",)),
    "edges": (np.int64, "edge", (2,)),
    "proven": (np.bool_, "edge", ()),
    "starts": (np.int64, "end", ()),
    "goals": (np.int64, "end", ()),
    "manipulability": (np.float64, "node", ()),
    "joint_length": (np.float64, "edge", ()),
    "tool_length": (np.float64, "edge", ()),
    "edge_manipulability": (np.float64, "edge", (W_STATES_PER_EDGE,)),
    "edge_cost": (np.float64, "edge", (len(COSTS),)),
    "clearance": (np.float64, "edge", ()),
    "samples": (np.int64, "edge", ()),
    "checked_by": (np.int8, "node", ()),
}
DTYPES = {name: dtype for name, (dtype, _, _) in ARRAYS.items()}
NODE_ARRAYS, EDGE_ARRAYS = (tuple(name for name in ARRAYS if ARRAYS[name][1] == of) for of in ("node", "edge"))


def component_labels(n: int, edges: Ints) -> Ints:
    """Return (n,) component numbers by minimum over neighbours with pointer jumping.

    SciPy takes 0.6 s to import.
    """
    label = np.arange(n)
    while len(edges):
        a, b = label[edges[:, 0]], label[edges[:, 1]]
        low = np.minimum(a, b)
        before = label.copy()
        np.minimum.at(label, a, low)
        np.minimum.at(label, b, low)
        label = label[label]
        if (label == before).all():
            break
    return np.unique(label, return_inverse=True)[1].astype(np.int64)


def path_waypoints(roadmap: Roadmap, robot: Robot, nodes: Ints) -> Floats:
    """Return the configurations (k, dof) of a node sequence, continuous joints unwound."""
    if not len(nodes):
        return np.zeros((0, robot.dof))
    return frozen(robot.unwound(roadmap.nodes[nodes]))


def with_min_clearance(roadmap: Roadmap, clearance: float) -> Roadmap:
    """Return the roadmap of the edges that are certified to have ``clearance`` (m)."""
    return roadmap.part(np.ones(len(roadmap.nodes), dtype=bool), roadmap.clearance >= clearance)


def try_min_clearance(roadmap: Roadmap, clearance: float) -> Roadmap:
    """Return :func:`with_min_clearance` if it still leads from a start to a goal, else the roadmap."""
    part = with_min_clearance(roadmap, clearance)
    return part if part.is_connected else roadmap


def restrict_to_constraints(roadmap: Roadmap, constraints: PathConstraints) -> Roadmap:
    """Return the roadmap of the nodes and edges that are proven to satisfy the path constraints."""
    if not constraints:
        return roadmap
    nodes = constraints.holds(roadmap.nodes)
    edges = np.all(nodes[roadmap.edges], axis=1)
    start, delta = edge_motions(roadmap, constraints.robot, np.flatnonzero(edges))
    edges[edges] = constraints.prove(np.stack([start, delta], axis=1))
    if not nodes.any():
        raise StateError("no node of the roadmap satisfies the constraints: build another roadmap, or give fewer.")
    return roadmap.part(nodes, edges)


def edge_motions(roadmap: Roadmap, robot: Robot, rows: Ints) -> tuple[Floats, Floats]:
    """Return starts and motions (k, dof) of the edges in ``rows``."""
    a, b = roadmap.nodes[roadmap.edges[rows, 0]], roadmap.nodes[roadmap.edges[rows, 1]]
    return a, robot.difference(a, b)
