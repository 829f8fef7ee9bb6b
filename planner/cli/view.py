"""``planner view`` and ``planner serve``: pages, and a server for other programs."""

from __future__ import annotations

import os
import threading
from dataclasses import fields
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Annotated, Any

import tyro
from typing_extensions import Doc

from planner.base.errors import FileError, OptionError, require_extra
from planner.base.files import make_folder, require_writable_file, write_whole
from planner.base.interrupts import catch_signals
from planner.cli.common import Debug
from planner.cli.terminal import open_in_browser, say
from planner.problem.request import LiveRequest, WorldRequest
from planner.problem.targets import AND, HOME, joints_text, parse_target

if TYPE_CHECKING:
    from planner.session.session import Session
    from planner.view.live import LivePage, Question


_RESULT = "A plan.json or sweep.json, its page, or its folder; with --live the folder of a plan."


def view(
    result: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="[RESULT]", help=_RESULT)] = None,
    world: WorldRequest = WorldRequest(),  # noqa: B008 (frozen)
    live_page: LiveRequest = LiveRequest(),  # noqa: B008
    state: Annotated[str | None, Doc("State of the robot, as 'planner plan' takes them; the start, or home.")] = None,
    live: Annotated[bool, Doc("Serve a page on which the scene can be changed, on this machine only.")] = False,
    out: Annotated[Path | None, Doc("Write the page to this file; with --live the file of the changed scene.")] = None,
    debug: Debug = False,
) -> int:
    """Show a result, a robot in a scene, or the live page.

    A result opens in the browser. Without RESULT the page shows the robot at --state: contacts, clearance,
    manipulability and limits, also of a state in collision. With --live the mouse moves obstacles and goal, and each
    change is planned on the same roadmap, until Ctrl-C; this needs pip install 'gabf-planner[live]'.
    """
    if result is not None and world != WorldRequest():
        raise OptionError("RESULT names its own robot and scene: give RESULT, or options of a world.")
    if state is not None and (live or result is not None):
        raise OptionError("--state needs a robot at rest: leave out RESULT and --live.")
    if live_page != LiveRequest() and (result is not None or not live):
        raise OptionError("--start, --goal, --beta, --nodes, --seed and --roadmap need --live, and no RESULT.")
    if result is not None and out is not None and not live:
        raise OptionError("RESULT has its own page: leave out --out.")
    if live:
        _serve(_make_live_page(result, world, live_page, out))
    elif result is not None:
        open_in_browser(_page_of(result).resolve().as_uri(), say)
    else:
        _show_state(world, state, out)
    return 0


def serve(
    host: Annotated[str, Doc("Address to listen on; the default is reached from this machine only.")] = "127.0.0.1",
    port: Annotated[int, Doc("Port to listen on; 0: any free one.")] = 0,
    token_file: Annotated[Path | None, Doc("File with the token of the clients; made where missing.")] = None,
    allow_xacro: Annotated[bool, Doc("Expand xacro files, whose expressions run on this machine.")] = False,
    debug: Debug = False,
) -> int:
    """Serve the gate and the planner over a websocket.

    Programs in other languages send JSON: load a robot and a scene, check chunks of joint targets, change the world,
    plan with progress and cancel. 'planner schema serve' describes the messages.
    """
    require_extra("websockets", "serve")
    from planner.serve.server import serve as run

    run(host, port, token_file, allow_xacro, say)
    return 0


def _serve(page: LivePage) -> None:
    """Wait for Ctrl-C, then end the page."""
    stop = threading.Event()
    say(page.outcome.value)
    with catch_signals(stop, "stopped during planning."):
        say(f"Serving {page.address} on this machine only; Ctrl-C ends it.")
        open_in_browser(page.address, say)
        while not stop.wait(0.5):  # a signal that reaches another thread does not wake this one
            pass
        page.close()


def _make_live_page(result: Path | None, request: WorldRequest, question: LiveRequest, out: Path | None) -> LivePage:
    """Return the live page with the answer to its first question."""
    for name in ("viser", "websockets"):
        require_extra(name, "live")
    from planner.session.session import Session
    from planner.view.live import LivePage, Question

    if result is not None:
        session, first = _session_of_plan(result if result.is_dir() else result.parent)
    else:
        first = Question(question.start.text, AND.join(goal.text for goal in question.goal), question.beta)
        world = {field.name: getattr(request, field.name) for field in fields(request)}  # type: ignore[arg-type]
        session = Session(**world, roadmap=question.roadmap, nodes=question.nodes, seed=question.seed)
    out = Path(f"{session.scene.name}-moved.yaml") if out is None else out
    if out.suffix.lower() not in (".yaml", ".yml"):
        raise OptionError(f"--out must be a scene file that ends in .yaml, got {out}.")
    require_writable_file(out)
    return LivePage(session, first, out)


def _session_of_plan(folder: Path) -> tuple[Session, Question]:
    """Return a session on the roadmap and in the world of the plan in ``folder``, and the plan's question."""
    from planner.planning.result import Plan
    from planner.session.session import OPTIONS, Session
    from planner.view.live import Question

    plan = Plan.load(folder)
    given, world = plan.request.values(), plan.checker.world
    # the robot knows the first five; refinement would take seconds per change
    in_robot = ("tool", "srdf", "group", "joints", "base", "base_limits", "refinement_rounds")
    options: dict[str, Any] = {name: given[name] for name in OPTIONS if name in given and name not in in_robot}
    options["constraint"] = world.conditions
    session = Session(plan.robot, plan.scene, roadmap=plan.roadmap, **options)
    ends = plan.request.config()
    start, goal = ends["start"], ends.get("goal", "")
    if len(plan.path) and (not goal or ends["request"] is not None):  # a tool path or a message says where
        start, goal = (joints_text(q.tolist()) for q in plan.path[[0, -1]])
    return session, Question(start, goal, given["beta"])


def _page_of(result: Path) -> Path:
    """Return the page of a result, given by its folder, its record or the page itself."""
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
    """Write the page of a robot at rest, and open it unless ``out`` names a file."""
    if out is not None:
        require_writable_file(out)
    target = None if state is None else parse_target(state)
    from planner.query.query import make_checker_for, states_of
    from planner.query.resolve import resolve_as_is
    from planner.view.state import inspect_state

    checker = make_checker_for(request)
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
