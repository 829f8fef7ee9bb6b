"""``planner roadmap``: grow once, query often."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from planner.base.errors import FileError, OptionError
from planner.cli.common import Debug, Flag
from planner.cli.terminal import facts, say, show, working
from planner.problem.request import KeptRequest, RoadmapRequest, require_nodes, require_seed

if TYPE_CHECKING:
    from planner.roadmap.roadmap import Roadmap

File = Annotated[Path, tyro.conf.Positional]

roadmap = tyro.extras.SubcommandApp()
roadmap.__doc__ = """Roadmaps that are kept: grow once, query often with 'planner plan --roadmap FILE.npz'.

A file says which robot and scene it was proven for, and how much room each edge has; it is refused for any other.
"""


@roadmap.command
def build(
    file: File,
    request: Annotated[RoadmapRequest, tyro.conf.arg(name="")] = RoadmapRequest(),  # noqa: B008 (frozen)
    debug: Debug = False,
) -> int:
    """Grow a roadmap around a start and a goal and keep it; every edge is proven free.

    Exit code 0: start and goal are joined; 4: they are not, the roadmap is kept all the same; 130: interrupted, what
    there is is kept, beside the file (as NAME.interrupted.npz) where there was one.

    Args:
        file: The file to write; what is there is replaced by a whole roadmap only.
    """
    from planner.base.files import require_writable_file

    require_writable_file(file)
    from planner.cli.interrupted import file_for_interrupted, kept
    from planner.construction.obtain import obtain_roadmap
    from planner.problem.outcome import Outcome
    from planner.problem.request import SweepRequest
    from planner.setup.open import make_query

    sweep = SweepRequest(**vars(request))
    with working() as progress:
        query = make_query(request, in_time=True)  # of the world that stands
        result = obtain_roadmap(sweep, query, progress)
        outcome = Outcome.INTERRUPTED if progress.stopped else Outcome.SOLVED if result.connected else Outcome.NO_PATH
        place = file_for_interrupted(file) if outcome is Outcome.INTERRUPTED else file
        _save(result, place)
    ending = "Start and goal are joined." if outcome is Outcome.SOLVED else outcome.value
    say(f"{_size(result)}. {ending} Written: {place}{kept(file, place)}")
    return outcome.exit_code


@roadmap.command
def info(file: File, json: Flag = False, debug: Debug = False) -> int:
    """Show what a roadmap file holds: whose it is, its size, its components, what its certificates promise.

    Args:
        file: A roadmap.npz.
        json: Print it as JSON.
    """
    from planner.base.files import json_text
    from planner.roadmap.storage import load_roadmap
    from planner.roadmap.summary import summary

    found = summary(load_roadmap(file))
    if json:
        say(json_text(found))
    else:
        show(facts(str(file), _info_rows(found)))
    return 0


@roadmap.command
def check(
    file: File,
    request: Annotated[KeptRequest, tyro.conf.arg(name="")] = KeptRequest(),  # noqa: B008 (frozen)
    repair: Flag = False,
    out: Path | None = None,
    debug: Debug = False,
) -> int:
    """Check that a roadmap belongs to a robot and a scene, and that every edge holds.

    With --repair a roadmap of another scene or a smaller margin is kept as far as it holds: edges that the difference
    does not touch stay, the others are proven again or dropped. Examples:

    planner roadmap check paper.npz

    planner roadmap check cell.npz --scene cell-of-today.yaml --repair --out cell-of-today.npz

    Exit code 0: everything holds, or was repaired; 3: it does not; 130: interrupted, nothing is written.

    Args:
        file: A roadmap.npz.
        repair: Write what holds instead of refusing the rest.
        out: Where the repaired roadmap goes; over the file where left out.
    """
    if out is not None and not repair:
        raise OptionError("--out says where a repaired roadmap goes: give --repair as well.")
    return _repair(file, request, out or file) if repair else _check(file, request)


def _check(file: Path, request: KeptRequest) -> int:
    from planner.collision.edge_prover import Verdict
    from planner.construction import repair as repairing
    from planner.construction.world_of import reopen
    from planner.roadmap.storage import load_roadmap, require_same_world

    kept = load_roadmap(file)
    checker = reopen(request, kept, file)
    require_same_world(kept, checker, file)
    with working() as progress:
        found = repairing.verify(kept, checker, progress)
        whole = found.complete and found.count(Verdict.FREE) == len(kept.edges)
        narrow = repairing.first_without_clearance(kept, checker, found, progress) if whole else None
        complete = found.complete and not progress.stopped
    undecided, collides = found.count(Verdict.UNDECIDED), found.count(Verdict.COLLIDES)
    say(
        f"{len(found.verdict)} of {len(kept.edges)} edges proven again: {found.count(Verdict.FREE)} hold, "
        f"{undecided} undecided, {collides} collide."
    )
    if not complete:
        return 130
    failure = repairing.first_failure(kept, checker, found)
    if failure is not None:
        i, j, contact = failure
        raise FileError(
            f"{undecided + collides} of {len(kept.edges)} edges of roadmap {file} do not hold, the first from node {i} "
            f"to {j} between {contact}: drop them with --repair."
        )
    if narrow is not None:
        i, j = kept.edges[narrow].tolist()
        raise FileError(
            f"roadmap {file} says that its edge from node {i} to {j} keeps {kept.clearance[narrow]:.3g} m, which is "
            "not proven: prove all anew with --repair."
        )
    outside = int((~repairing.within_limits(kept, checker.robot)).sum())
    if outside:
        raise FileError(f"{outside} nodes of roadmap {file} are outside the joint limits: drop them with --repair.")
    if not repairing.measures_hold(kept, checker.robot):
        raise FileError(f"roadmap {file} has wrong manipulabilities or lengths: measure them again with --repair.")
    return 0


def _repair(file: Path, request: KeptRequest, target: Path) -> int:
    from planner.base.files import require_writable_file
    from planner.construction import repair as repairing
    from planner.construction.world_of import reopen
    from planner.roadmap.storage import load_roadmap

    kept = load_roadmap(file)
    require_writable_file(target)
    checker = reopen(request, kept, file)
    with working() as progress:
        result = repairing.repair(kept, checker, progress)
        if result is not None:
            _save(result.roadmap, target)
    if result is None:
        say(f"Interrupted before every edge was judged: {target} is as it was.")
        return 130
    for change in result.changes:
        say(f"Difference: {change}.")
    say(
        f"Edges: {result.kept} kept without another proof, {result.proven} proven again, {result.dropped} dropped; "
        f"{result.nodes_dropped} nodes dropped. {_size(result.roadmap)}. Written: {target}"
    )
    if result.roadmap.component_count > kept.component_count:
        say("It fell into more components: 'planner roadmap extend' grows new paths between them.")
    return 0


@roadmap.command
def extend(
    file: File,
    nodes: int,
    request: Annotated[KeptRequest, tyro.conf.arg(name="")] = KeptRequest(),  # noqa: B008 (frozen)
    seed: int | None = None,
    out: Path | None = None,
    debug: Debug = False,
) -> int:
    """Grow a roadmap further: its nodes keep their numbers, and costs mean what they did.

    Exit code 0: done; 3: another robot or scene; 130: interrupted, what there is is kept, beside --out where that
    was there already.

    Args:
        file: A roadmap.npz.
        nodes: How many configurations to add.
        seed: Seed of the new ones; left out, it follows from the roadmap.
        out: Where the larger roadmap goes; over the file where left out.
    """
    if nodes < 1:
        raise OptionError(f"{nodes} nodes are no extension: give a whole number from 1.")
    if seed is not None:
        require_seed(seed)
    from planner.base.files import require_writable_file
    from planner.cli.interrupted import file_for_interrupted
    from planner.cli.interrupted import kept as was_kept
    from planner.construction.extend import extend as grow_on
    from planner.construction.world_of import reopen
    from planner.roadmap.storage import load_roadmap, require_same_world

    kept, target = load_roadmap(file), out or file
    require_nodes(len(kept.nodes) + nodes)
    require_writable_file(target)
    checker = reopen(request, kept, file)
    require_same_world(kept, checker, file)
    with working() as progress:
        result = grow_on(kept, checker, nodes, seed, progress=progress)
        # over the file itself nothing is lost: all of it is in the result
        place = file_for_interrupted(target) if progress.stopped and target != file else target
        _save(result, place)
    more = f"{len(result.nodes) - len(kept.nodes)} nodes and {len(result.edges) - len(kept.edges)} edges more"
    say(f"{more}: {_size(result)}. Written: {place}{was_kept(target, place)}")
    return 130 if progress.stopped else 0


def _save(result: Roadmap, file: Path) -> None:
    from planner.base.files import make_folder
    from planner.roadmap.storage import save_roadmap

    make_folder(file.parent)
    save_roadmap(result, file)


def _size(result: Roadmap) -> str:
    count = result.component_count
    return f"{len(result.nodes)} nodes, {len(result.edges)} edges, {count} component{'' if count == 1 else 's'}"


def _info_rows(found: dict[str, Any]) -> list[tuple[str, str]]:
    sizes, degree, w = found["components"], found["degree"], found["manipulability"]
    sides = ", ".join(map(str, sizes[:8])) + " nodes" + (f" and {len(sizes) - 8} more" if len(sizes) > 8 else "")
    joined = "" if found["connected"] else "; start and goal are not joined"
    return [
        ("robot", f"{found['robot']} ({', '.join(found['joints'])}), tool frame {found['tool']}"),
        ("scene", f"{found['scene']} ({len(found['obstacles'])} obstacles), margin {found['margin']:g} m"),
        ("grown with", f"seed {found['seed']}; " + ", ".join(f"{k} {v}" for k, v in found["versions"].items())),
        ("nodes", f"{found['nodes']}; starts {found['starts']}, goals {found['goals']}"),
        ("edges", f"{found['edges']}, {found['edges_certified']} of them proven free"),
        ("components", f"{len(sizes)}: {sides}{joined}"),
        ("edges per node", f"{degree['min']} to {degree['max']}, mean {degree['mean']:.2f}"),
        ("manipulability w", ", ".join(f"{100 * float(q):g} %: {value:.5f}" for q, value in w.items())),
        ("edge length", f"{_spread(found['joint_length'], 'rad')}; tool {_spread(found['tool_length'], 'm')}"),
        ("clearance proven", f"beyond the margin {_spread(found['clearance'], 'm')}; {found['samples']} samples"),
        ("sha256", found["sha256"]),
    ]


def _spread(values: dict[str, float | None], unit: str) -> str:
    text = {key: "any" if value is None else f"{value:.4f}" for key, value in values.items()}
    return f"{text['min']} to {text['max']} {unit}, median {text['median']}"
