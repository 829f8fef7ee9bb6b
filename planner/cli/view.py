"""``planner view`` and ``planner serve``: pages, and answers to other programs."""

from __future__ import annotations

import os
import threading
from dataclasses import fields
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from planner.base.errors import FileError, OptionError, require_extra
from planner.base.files import make_folder, require_writable_file, write_whole
from planner.base.interrupts import until_signal
from planner.cli.common import Debug, Flag
from planner.cli.terminal import open_in_browser, say
from planner.problem.request import LiveRequest, WorldRequest
from planner.problem.targets import AND, HOME, joints_text, parse_target

if TYPE_CHECKING:
    from planner.session.session import Session
    from planner.view.live import LivePage, Question


def view(
    result: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[RESULT]")] = None,
    request: WorldRequest = WorldRequest(),  # noqa: B008 (frozen)
    state: str | None = None,
    live: Flag = False,
    question: LiveRequest = LiveRequest(),  # noqa: B008
    out: Path | None = None,
    debug: Debug = False,
) -> int:
    """Look at a result, or at a robot in a scene before anything is planned.

    Opens the page in the browser; where there is none it prints the place of the page. Examples:

    planner view out

    planner view --robot ur5 --scene table --state q:0,-1.2,1,-1,-1.5,0 --out state.html

    planner view --live --robot panda --scene shelf --out shelf-moved.yaml

    Without RESULT it shows the robot at --state: which pairs touch, how near the rest is, manipulability and limits;
    the state may be in collision or out of limits. With --live obstacles and the goal are moved with the mouse, and
    each change is planned on the same roadmap, on a page that is served on this machine only, until Ctrl-C; it needs
    pip install 'gabf-planner[live]'.

    Args:
        result: plan.json, sweep.json, their page, or their folder; with --live the folder of a plan.
        state: A name from the scene, q:..., xyz:... or pose:... as 'planner plan' takes them; the scene's start where
            left out, or the robot's home.
        live: A page on which the scene can be changed; --start, --goal, --beta, --nodes, --seed and --roadmap are for
            it.
        out: Write the state's page to this file instead of opening it; with --live the file that Save writes the scene
            to, <scene>-moved.yaml where left out.
    """
    if result is not None and request != WorldRequest():
        raise OptionError("a result has its own robot and scene: give RESULT or options for a world, not both.")
    if state is not None and (live or result is not None):
        raise OptionError("--state is for a robot at rest: leave out RESULT and --live.")
    if question != LiveRequest() and (result is not None or not live):
        raise OptionError(
            "--start, --goal, --beta, --nodes, --seed and --roadmap are for --live: add it, and no RESULT."
        )
    if result is not None and out is not None and not live:
        raise OptionError("a result has its own page: leave out --out.")
    if live:
        _serve(_live_page(result, request, question, out))
    elif result is not None:
        open_in_browser(_page_of(result).resolve().as_uri(), say)
    else:
        _show_state(request, state, out)
    return 0


def serve(
    host: str = "127.0.0.1",
    port: int = 0,
    token_file: Path | None = None,
    allow_xacro: bool = False,
    debug: Debug = False,
) -> int:
    """Serve the gate and the planner to programs in other languages, over a websocket, until Ctrl-C.

    Messages are JSON: load a robot and a scene, check chunks of joint targets, change the world, plan with progress
    and cancel. 'planner schema serve' describes them; docs/howto/serve.md has clients. Example:

    planner serve --host 0.0.0.0 --port 8765 --token-file token

    Args:
        host: Address to listen on: this machine's own, so that no other reaches it.
        port: Port to listen on; any free one where left out.
        token_file: File with the token that clients send; a random one is written where there is no such file.
        allow_xacro: Expand robots that are written as xacro, whose expressions run on this machine.
    """
    require_extra("websockets", "serve")
    from planner.serve.server import serve as run

    run(host, port, token_file, allow_xacro, say)
    return 0


def _serve(page: LivePage) -> None:
    """Wait for Ctrl-C, then end the page."""
    asked = threading.Event()
    say(page.outcome.value)
    with until_signal(asked, "stopped during planning."):
        say(f"Serving {page.address} on this machine only; Ctrl-C ends it.")
        open_in_browser(page.address, say)
        while not asked.wait(0.5):  # a signal that reaches another thread does not wake this one
            pass
        page.close()


def _live_page(result: Path | None, request: WorldRequest, question: LiveRequest, out: Path | None) -> LivePage:
    """The live page with its first question answered."""
    for name in ("viser", "websockets"):
        require_extra(name, "live")
    from planner.session.session import Session
    from planner.view.live import LivePage, Question

    if result is not None:
        session, asked = _session_of_plan(result if result.is_dir() else result.parent)
    else:
        asked = Question(question.start.text, AND.join(goal.text for goal in question.goal), question.beta)
        world = {field.name: getattr(request, field.name) for field in fields(request)}  # type: ignore[arg-type]
        session = Session(**world, roadmap=question.roadmap, nodes=question.nodes, seed=question.seed)
    out = Path(f"{session.scene.name}-moved.yaml") if out is None else out
    if out.suffix.lower() not in (".yaml", ".yml"):
        raise OptionError(f"--out must be a scene file that ends in .yaml, got {out}.")
    require_writable_file(out)
    return LivePage(session, asked, out)


def _session_of_plan(folder: Path) -> tuple[Session, Question]:
    """A session on the roadmap of the plan in ``folder``, in the plan's world, and the question of the plan."""
    from planner.planning.result import Plan
    from planner.session.session import OPTIONS, Session
    from planner.view.live import Question

    plan = Plan.load(folder)
    given, world = plan.request.values(), plan.checker.world
    in_robot = (
        "tool",
        "srdf",
        "group",
        "joints",
        "base",
        "refinement_rounds",
    )  # the last one refines, which takes seconds
    options: dict[str, Any] = {name: given[name] for name in OPTIONS if name in given and name not in in_robot}
    options["constraint"] = world.conditions
    session = Session(plan.robot, plan.scene, roadmap=plan.roadmap, **options)
    ends = plan.request.config()
    start, goal = ends["start"], ends.get("goal", "")
    if len(plan.path) and (not goal or ends["request"] is not None):  # a tool path or a message says where
        start, goal = (joints_text(q.tolist()) for q in plan.path[[0, -1]])
    return session, Question(start, goal, given["beta"])


def _page_of(result: Path) -> Path:
    """The page of a result given by its folder, its record or the page itself."""
    if os.path.isdir(result):
        pages = [result / name for name in ("plan.html", "sweep.html") if os.path.isfile(result / name)]
        if len(pages) != 1:
            raise FileError(f"folder {result} must hold a plan.html or a sweep.html, got {len(pages)}: name the file.")
        return pages[0]
    page = result.with_suffix(".html") if result.suffix.lower() == ".json" else result
    if not os.path.isfile(page):
        raise FileError(f"page {page} not found: check the path, or plan again.")
    return page


def _show_state(request: WorldRequest, state: str | None, out: Path | None) -> None:
    """Write the page of a robot at rest, and open it where no file was named."""
    if out is not None:
        require_writable_file(out)
    target = None if state is None else parse_target(state)
    from planner.query.query import open_world, states_of
    from planner.query.resolve import resolve_as_is
    from planner.view.state import inspect_state

    checker = open_world(request)
    states = states_of(checker.robot, checker.world.scene)
    if target is None:
        target = parse_target("start" if "start" in states else HOME)
    report = inspect_state(checker, resolve_as_is(target, checker, states, "state"))
    say(report.sentence)
    file = Path(mkdtemp(prefix="planner-")) / "state.html" if out is None else out
    make_folder(file.parent)
    write_whole(file, report.page().encode())
    say(f"Written: {file}")
    if out is None:
        open_in_browser(file.as_uri(), say)
