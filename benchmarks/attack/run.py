"""Attacks every claim that proofs rest on; the truth is computed by slow methods that share nothing with them.

How. Hill climbing from random starts, stopped on counts, looks for the largest claim minus truth. Claims: two random
shapes (1 mm to 3 m, meshes of plates, loose and degenerate triangles, boxes and strips) near each other, up to a
kilometre from the origin, one carried by an arm and the other an obstacle or carried too. Asked are `distances` of the
checker, `coarse` and `close` of the bounds that prove, and for one pair in twelve the verdict on the state with a
margin that is not kept, or on an overlap. Segments: one that an arm of two joints, or a robot, moves past one shape,
put to the prover; where that says free the true distance along it is minimised. Points (alone, in needles, patches
and heaps, or many times), voxels and depth images are obstacles as well, some with a margin, some inside a link; a part
of one within a closed mesh counts as a contact. The truth is computed by Wolfe's algorithm between convex parts,
triangle by triangle: two points bound it from above, a plane from below ("open" in the table as CSV is the widest gap
between both), and touching is 0. "Short" is truth minus claim: safe, but such edges are left unproven.

Misses. Walls, poles (round or square) and windows (four boards) of the given thickness stand where a link of a random
edge passes, at a random pose, a little off; an edge counts when both its ends are free. Every edge is sampled at each
0.1 mm of motion of any point of the arm by coal, and those that the prover certified with coal by FCL as well: an edge
certified with one library on which the other finds a contact is false. OMPL's rule is that of its
DiscreteMotionValidator with default settings: equal parts no longer than 0.01 of the space's largest extent, those
states checked by coal. "Left out" are edges on which no contact was found and which were not certified.

Proofs (with --problems and --python). In the scene of every problem random straight motions begin at free
configurations, and take a random share of the way to random others; both get the same URDF, limits, link pairs and
obstacles. HPP proves by Dichotomy without a tolerance and by Progressive with 0.1 mm, which it needs. Motions that one
of them proves alone are looked at by coal at every 0.1 mm.

Certificates. A plan of every robot in every scene is saved with a certificate and checked. Changes: the certificate of
a path and a motion of the planar arm around a post is changed at random, and by an adversary who looks for the largest
change that is still accepted; accepted ones are judged with SciPy's rotations, least squares and singular values.

Limitations. A search finds what it finds: no claim above the truth is no proof that there is none. The true distance
along a segment is that at places, the nearest refined: a contact may be missed, never invented. Verdicts on overlaps of
two meshes are not attacked, nor meshes of many triangles. States every 0.1 mm are no proof: a contact shorter than that
is not seen. Edges past thin obstacles are aimed at them, so shares are not those of a usual scene. HPP is asked motion
by motion from Python, our prover all at once on all cores: its seconds are no measure of the method. Certificates are
changed in one small world.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from itertools import combinations_with_replacement, product
from pathlib import Path
from typing import Any, Literal

import numpy as np

from benchmarks import bench
from benchmarks.attack import cases as shapes
from benchmarks.attack import misses, proofs, thin_obstacles
from benchmarks.attack.certificates import run as certificates
from benchmarks.attack.claims import attack_claims
from benchmarks.attack.report import aims, fault, tables
from benchmarks.attack.segments import attack_segments
from benchmarks.problems import Problem, find_problems
from planner.base.errors import OptionError
from planner.base.progress import Progress
from planner.collision import BACKENDS
from planner.problem.options import Backend
from planner.problem.request import PlanRequest, RoadmapQuality
from planner.robot.robot import Robot
from planner.robot.scene import Scene

Part = Literal["claims", "segments", "misses", "proofs", "certificates", "changes"]
ROBOTS = ("planar_2r", "iiwa14")
PAIRS = tuple(combinations_with_replacement(shapes.KINDS, 2))
SEEN_PAIRS = tuple(product(("box", "cylinder", "mesh"), shapes.SEEN))


def attack(
    out: bench.Out = Path("bench-attack"),
    parts: tuple[Part, ...] = ("claims", "segments", "misses", "proofs", "certificates", "changes"),
    seed: int = 0,
    tries: int = 1000,
    segments: int = 100,
    edges: int = 40,
    thicknesses: tuple[float, ...] = (1.0, 2.0, 3.0, 4.0, 5.0),
    changes: int = 10_000,
    motions: int = 2000,
    robots: tuple[str, ...] = (),
    scenes: tuple[str, ...] = certificates.SCENES,
    libraries: tuple[Backend, ...] = BACKENDS,
    problems: Path | None = None,
    python: str | None = None,
    workers: bench.Workers = bench.SERIAL,
    debug: bench.Debug = False,
) -> int:
    """An optimiser against every claim that proofs rest on: distances, bounds, motions, segments, certificates.

    Claims: the largest claim minus truth of distances and bounds, over shapes, sizes and poses. Segments: those that
    are called free. Misses: edges past obstacles of a few millimetres, by the proof and by
    OMPL's default resolution, looked at every 0.1 mm. Proofs: ours against HPP's, with --problems and --python, left
    out without. Certificates: of plans, and their cost; changes: certificates that were changed. Writes attack.csv and
    attack.md. Exit code 4 where a false claim was found.

    Args:
        parts: Parts to run.
        seed: Seed of the searches.
        tries: Pairs of shapes for each two kinds and library.
        segments: Segments put to the proof for each two kinds of shapes, and each robot, and library.
        edges: Edges for each robot, kind of thin obstacle and thickness.
        thicknesses: Of the thin obstacles, in millimetres.
        changes: Changed certificates to try.
        motions: Straight motions for HPP and our prover, shared out among the scenes.
        robots: Names of built-in robots or paths of URDFs; where left out, each part has its own.
        scenes: Scenes to certify plans in, each with each robot.
        libraries: Collision libraries to attack.
        problems: Folder of planning problems for the Panda, whose scenes HPP is compared in.
        python: Python of an environment of its own with hpp-python in it.
    """
    RoadmapQuality(seed=seed)  # refuses a seed out of range
    if min(tries, segments, edges, changes, motions) < 1 or not all(0.0 < t <= 100.0 for t in thicknesses):
        raise OptionError("give at least 1 of what is tried, and thicknesses above 0 and up to 100 mm.")
    for name in robots:
        Robot.load(name)
    for name in scenes:
        Scene.load(name)
    arms = robots or ROBOTS
    pairs = (*PAIRS, *SEEN_PAIRS)
    swept: list[tuple[str, str]] = [*pairs, *product(arms, ("mesh", "points"))]
    thin = product(robots or misses.ROBOTS, thin_obstacles.KINDS, map(float, thicknesses))
    cases: dict[str, list[bench.Case]] = {
        "claims": [_case("claims", *pair, library, tries, seed) for pair in pairs for library in libraries],
        "segments": [_case("segments", *pair, library, segments, seed) for pair in swept for library in libraries],
        "misses": [
            _case("misses", name, kind, (misses.RULE, *BACKENDS), edges, seed, thickness=t) for name, kind, t in thin
        ],
        "proofs": _proof_cases(problems, python, motions, seed),
        "certificates": [
            _case("certificates", name, scene, "", 1, seed)
            for name, scene in product(robots or certificates.ROBOTS, scenes)
        ],
        "changes": [
            _case("changes", "chunk", str(k), "", certificates.CHUNK, seed)
            for k in range(-(-changes // certificates.CHUNK))
        ],
    }
    return bench.run_bench(
        BENCH, out, [case for part in dict.fromkeys(parts) for case in cases[part]], _measure, workers
    )


def _case(
    attack: str,
    first: str,
    second: str,
    libraries: str | Sequence[str],
    tries: int,
    seed: int,
    thickness: float = 0.0,
    content: str = "",
    more: Any = None,
) -> bench.Case:
    names = (libraries,) if isinstance(libraries, str) else libraries
    columns, settings = "attack first second library thickness_mm tries seed content", (thickness, tries, seed, content)
    rows = tuple(bench.make_settings(columns, attack, first, second, name, *settings) for name in names)
    return bench.Case(rows, (rows[0], more))


def _proof_cases(problems: Path | None, python: str | None, motions: int, seed: int) -> list[bench.Case]:
    """A case per scene; none without the problems and HPP's environment."""
    if problems is None or python is None:
        return []
    found, plain = (
        find_problems(problems),
        PlanRequest.from_options(robot="panda", collision="coal", widen_limits=True, seed=seed),
    )
    if motions < len(found):
        raise OptionError(f"{motions} motions are too few for {len(found)} scenes: give at least one for each.")
    each = -(-motions // len(found))
    return [
        _case("proofs", one.name, "", proofs.METHODS, each, seed, content=one.content(plain), more=(one, plain, python))
        for one in found
    ]


def _measure(task: tuple[bench.Row, Any], progress: Progress) -> Any:
    """The columns of one attack; None where stopped."""
    row, more = task
    # each row has a stream of its own, so that it is the same whichever others were asked for
    rng = np.random.default_rng([row.seed, *row.attack.encode(), *row.first.encode(), *row.second.encode()])
    return _ATTACKS[row.attack](row, rng, progress, more)


def _claims(row: bench.Row, rng: np.random.Generator, progress: Progress, _: None) -> dict[str, Any] | None:
    worst = attack_claims((row.first, row.second), row.library, row.tries, rng, progress)
    if worst is None:
        return None
    return {
        "tried": worst.tried,
        "apart": worst.apart,
        "distances_m": worst.over["distances"],
        "coarse_m": worst.over["coarse"],
        "close_m": worst.over["close"],
        "verdict_m": worst.over.get("verdict"),
        "beyond_m": worst.beyond,
        "short_m": worst.short,
        "open_m": worst.open,
        "found": json.dumps(worst.found),
    }


def _segments(row: bench.Row, rng: np.random.Generator, progress: Progress, _: None) -> dict[str, Any] | None:
    proven = attack_segments((row.first, row.second), row.library, row.tries, rng, progress)
    if proven is None:
        return None
    return {
        "tried": proven.tried,
        "free": proven.free,
        "false_free": proven.false_free,
        "clearance_m": proven.over if proven.found else None,
        "found": json.dumps(proven.found.describe()) if proven.found else "",
    }


def _misses(row: bench.Row, _: np.random.Generator, progress: Progress, more: None) -> list[dict[str, Any]] | None:
    return misses.attack_edges(row.first, row.second, row.thickness_mm, row.tries, row.seed, progress)


def _proofs(
    row: bench.Row, _: np.random.Generator, progress: Progress, more: tuple[Problem, PlanRequest, str]
) -> list[dict[str, Any]]:
    return proofs.compare_proofs(*more, row.tries)


_ATTACKS: dict[str, Callable[..., Any]] = {
    "claims": _claims,
    "segments": _segments,
    "misses": _misses,
    "proofs": _proofs,
    "certificates": lambda row, *_: certificates.certify(row.first, row.second, row.seed),
    "changes": lambda row, *_: certificates.change(int(row.second), row.seed),
}

BENCH = bench.Bench("attack", __doc__, tables, aims, fault, must_hold=True)
