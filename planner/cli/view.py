"""``planner view``."""

from __future__ import annotations

import os
import sys
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from planner.base.errors import FileError, OptionError
from planner.cli.arguments import options_in
from planner.cli.common import Debug, Flag
from planner.cli.terminal import say
from planner.problem.request import LiveRequest, WorldRequest
from planner.problem.targets import HOME, parse_target

if TYPE_CHECKING:
    from planner.live.controller import LiveController


def view(
    result: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[RESULT]")] = None,
    request: Annotated[WorldRequest, tyro.conf.arg(name="")] = WorldRequest(),  # noqa: B008 (frozen)
    state: str | None = None,
    live: Flag = False,
    question: Annotated[LiveRequest, tyro.conf.arg(name="")] = LiveRequest(),  # noqa: B008 (frozen)
    out: Path | None = None,
    port: int = 0,
    open: Flag = False,
    debug: Debug = False,
) -> int:
    """Look at a result, or at a robot in a scene before anything is planned.

    Serves the page on this machine only (127.0.0.1), until Ctrl-C. A page made by 'planner plan' or 'planner sweep'
    also opens from disk. Examples:

    planner view out

    planner view sweep/sweep.json --port 8000 --open

    planner view --robot panda --scene shelf --state home

    planner view --robot ur5 --scene table --state q:0,-1.2,1,-1,-1.5,0 --out state.html

    planner view --live --robot panda --scene shelf --out shelf-moved.yaml

    Without RESULT it shows the robot at --state: which pairs touch, how near the rest is, manipulability and limits;
    the state may be in collision or out of limits.

    With --live obstacles and the goal can be dragged, and the start set by sliders; what is let go is planned anew, on
    the same roadmap. Only who knows the whole address that is printed can open it.

    Args:
        result: plan.json, sweep.json, their page, or their folder.
        state: A name from the scene, q:..., xyz:... or pose:... as 'planner plan' takes them; the scene's start where
            left out, or the robot's home.
        live: A page on which the scene can be changed; --start, --goal, --beta, --nodes, --seed and --roadmap are for
            it.
        out: Write the state's page to this file instead of serving it; with --live the file that the page's scene is
            saved to, <scene>-moved.yaml where left out.
        port: Port to serve on; any free one where left out.
        open: Open the page in the browser, where there is a screen.
    """
    from planner.base.files import require_writable_file
    from planner.view.serve import require_free_port, serve

    require_free_port(port)
    if live:
        if result is not None or state is not None:
            raise OptionError(
                "--live plans anew: give it --robot, --scene, --start and --goal, no RESULT and no --state."
            )
        serve(_controller(request, question, out), port, open, say)
        return 0
    if options_in(sys.argv[1:]) & {f"--{field.name}" for field in fields(LiveRequest)}:  # defaults, too
        raise OptionError("--start, --goal, --beta, --nodes, --seed and --roadmap are for --live: add it.")
    if result is not None:
        if request != WorldRequest() or state is not None or out is not None:
            raise OptionError(
                "a result has its own robot, scene and page: give RESULT or options for a state, not both."
            )
        page = _page_beside(result)
    else:
        if out is not None:
            if port or open:
                raise OptionError("--out writes the page and serves none: leave out --port and --open, or --out.")
            require_writable_file(out)
        page = _state_page(request, state)
        if out is not None:
            return _write(page, out)
    serve(page, port, open, say)
    return 0


def _controller(request: WorldRequest, question: LiveRequest, out: Path | None) -> LiveController:
    """The live page's other side, with its first question answered."""
    from planner.base.files import require_writable_file
    from planner.live.controller import LiveController
    from planner.live.state import Question
    from planner.models.frames import in_world
    from planner.models.scene import Scene
    from planner.session.session import Session

    out = Path(f"{Path(str(request.scene)).stem}-moved.yaml") if out is None else out
    if out.suffix.lower() not in (".yaml", ".yml"):
        raise OptionError(f"--out {out} is no scene file: give a name that ends in .yaml.")
    require_writable_file(out)
    world = {field.name: getattr(request, field.name) for field in fields(request)}
    session = Session(**world, roadmap=question.roadmap, nodes=question.nodes, seed=question.seed)
    asked = Question(str(question.start), str(question.goal), question.beta)
    robot = session.live.bare
    controller = LiveController(session, asked, lambda: in_world(Scene.load(str(request.scene)), robot), out)
    say(controller.message)
    return controller


def _page_beside(result: Path) -> Path:
    """The page of a result given by its folder, its record or the page itself."""

    if not os.path.isdir(result):
        return result.with_suffix(".html") if result.suffix.lower() == ".json" else result
    pages = [result / name for name in ("plan.html", "sweep.html") if os.path.isfile(result / name)]
    if not pages:
        raise FileError(f"folder {result} holds neither plan.html nor sweep.html: 'planner plan --out {result}' first.")
    if len(pages) > 1:
        raise FileError(f"folder {result} holds plan.html and sweep.html: name one of them.")
    return pages[0]


def _state_page(request: WorldRequest, state: str | None) -> str:
    target = None if state is None else parse_target(state)
    from planner.setup.open import open_world, states_of
    from planner.setup.resolve import resolve_as_is
    from planner.view.state import inspect_state, state_page

    checker = open_world(request)
    states = states_of(checker.robot, checker.world.scene)
    if target is None:
        target = parse_target("start" if "start" in states else HOME)
    report = inspect_state(checker, resolve_as_is(target, checker, states, "state"))
    say(report.sentence)
    return state_page(report)


def _write(page: str, out: Path) -> int:
    from planner.base.files import make_folder, write_whole

    make_folder(out.parent)
    write_whole(out, page.encode())
    say(f"Written: {out}")
    return 0
