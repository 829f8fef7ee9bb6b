"""``planner roadmap``: grow once, query often."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import tyro

from planner.base.files import json_text, make_folder, require_writable_file
from planner.cli.common import Debug, Flag, Problem, file_for_interrupted, kept
from planner.cli.terminal import facts, say, show, working
from planner.problem.outcome import Outcome
from planner.problem.request import RoadmapQuality

File = Annotated[Path, tyro.conf.Positional]

roadmap = tyro.extras.SubcommandApp()
roadmap.__doc__ = """Roadmaps that are kept: grow once, query often with 'planner plan --roadmap FILE.npz'.

A file names the robot and the scene that it was proven for. In another scene all its edges are proven again.
"""


@roadmap.command
def build(
    file: File,
    what: Problem = Problem(),  # noqa: B008 (frozen)
    quality: RoadmapQuality = RoadmapQuality(),  # noqa: B008
    debug: Debug = False,
) -> int:
    """Grow a roadmap around a start and a goal and keep it; every edge is proven free.

    Exit code 0: start and goal are joined; 4: they are not, and the roadmap is written; 130: interrupted, the partial
    roadmap is written, as NAME.interrupted.npz where FILE was there before.

    Args:
        file: The file to write.
    """
    require_writable_file(file)
    from planner.query.query import make_query
    from planner.roadmap.obtain import obtain_roadmap
    from planner.roadmap.storage import save_roadmap

    with working() as progress:
        query = make_query(what, in_time=True)  # of the world that stands
        result = obtain_roadmap(quality, query, progress)
        outcome = Outcome.INTERRUPTED if progress.stopped else Outcome.SOLVED if result.connected else Outcome.NO_PATH
        place = file_for_interrupted(file) if outcome is Outcome.INTERRUPTED else file
        make_folder(place.parent)
        save_roadmap(result, place)
    ending = "Start and goal are joined." if outcome is Outcome.SOLVED else outcome.value
    components = "1 component" if result.component_count == 1 else f"{result.component_count} components"
    size = f"{len(result.nodes)} nodes, {len(result.edges)} edges, {components}"
    say(f"{size}. {ending} Written: {place}{kept(file, place)}")
    return outcome.exit_code


@roadmap.command
def info(file: File, json: Flag = False, debug: Debug = False) -> int:
    """Show what a roadmap file holds: whose it is, its size, its components, what its certificates promise.

    Args:
        file: A roadmap.npz.
        json: Print it as JSON.
    """
    from planner.roadmap.storage import load_roadmap, summary

    found = summary(load_roadmap(file))
    if json:
        say(json_text(found))
    else:
        show(facts(str(file), _info_rows(found)))
    return 0


def _info_rows(found: dict[str, Any]) -> list[tuple[str, str]]:
    sizes, degree, w = found["components"], found["degree"], found["manipulability"]
    sides = ", ".join(map(str, sizes[:8])) + " nodes" + (f" and {len(sizes) - 8} more" if len(sizes) > 8 else "")
    joined = "" if found["connected"] else "; start and goal are not joined"
    return [
        ("robot", f"{found['robot']} ({', '.join(found['joints'])}), tool frame {found['tool']}"),
        ("scene", f"{found['scene']}, margin {found['margin']:g} m"),
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
