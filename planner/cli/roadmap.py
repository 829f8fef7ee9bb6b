"""``planner roadmap``: build a roadmap once, plan on it often."""

from pathlib import Path
from typing import Annotated, Any

import tyro
from typing_extensions import Doc

from planner.base.files import json_text, make_folder, require_writable_file
from planner.cli.common import Debug, Json, Problem, choose_file, other_place
from planner.cli.terminal import facts, say, show, working
from planner.problem.outcome import Outcome
from planner.problem.request import RoadmapQuality

File = Annotated[Path, tyro.conf.Positional, Doc("A roadmap.npz.")]

roadmap = tyro.extras.SubcommandApp()
roadmap.__doc__ = """Build a roadmap, or show the content of a file.

'planner plan --roadmap FILE.npz' plans on it. In another scene all its edges are proven again.
"""


@roadmap.command
def build(
    file: File,
    problem: Problem = Problem(),  # noqa: B008 (frozen)
    quality: RoadmapQuality = RoadmapQuality(),  # noqa: B008
    debug: Debug = False,
) -> int:
    """Build a roadmap around a start and a goal and save it.

    Every edge is proven free. Exit codes: 0 start and goal are connected, 4 they are not, and the roadmap is written,
    130 interrupted.
    """
    require_writable_file(file)
    from planner.query.query import make_query
    from planner.roadmap.load_or_build import load_or_build_roadmap
    from planner.roadmap.storage import save_roadmap

    with working() as progress:
        query = make_query(problem, in_time=True)  # of the world that stands
        result = load_or_build_roadmap(quality, query, progress)
        outcome = (
            Outcome.INTERRUPTED if progress.stopped else Outcome.SOLVED if result.is_connected else Outcome.NO_PATH
        )
        place = choose_file(file) if outcome is Outcome.INTERRUPTED else file
        make_folder(place.parent)
        save_roadmap(result, place)
    ending = "Start and goal are connected." if outcome is Outcome.SOLVED else outcome.value
    components = "1 component" if result.component_count == 1 else f"{result.component_count} components"
    size = f"{len(result.nodes)} nodes, {len(result.edges)} edges, {components}"
    say(f"{size}. {ending} Written: {place}{other_place(file, place)}")
    return outcome.exit_code


@roadmap.command
def info(file: File, json: Json = False, debug: Debug = False) -> int:
    """Show the content of a roadmap file.

    The robot and scene, its size and components, and the guarantees of its certificates.
    """
    from planner.roadmap.storage import load_roadmap, summarize

    found = summarize(load_roadmap(file))
    if json:
        say(json_text(found))
    else:
        show(facts(str(file), [(name.replace("_", " "), _text(value)) for name, value in found.items()]))
    return 0


def _text(value: Any) -> str:
    """A value of a summary for the terminal."""
    if isinstance(value, dict):
        return ", ".join(f"{name} {_text(each)}" for name, each in value.items())
    if isinstance(value, list | tuple):
        more = f" and {len(value) - 8} more" if len(value) > 8 else ""
        return ", ".join(map(_text, value[:8])) + more
    return "any" if value is None else f"{value:.5g}" if isinstance(value, float) else str(value)
