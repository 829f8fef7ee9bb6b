"""The command line: typed functions are the commands, their docstrings the help. The one place that prints."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from planner.errors import PlannerError
from planner.request import PlanRequest

if TYPE_CHECKING:
    from rich.progress import Progress
    from rich.table import Table

    from planner.experiments.report import Verdict

_STARTED = time.perf_counter()

app = tyro.extras.SubcommandApp()
Flag = tyro.conf.FlagCreatePairsOff[bool]


@app.command
def plan(
    request: Annotated[PlanRequest, tyro.conf.arg(name="")] = PlanRequest(),  # noqa: B008 (frozen)
    out: Path = Path("out"),
    debug: Flag = False,
) -> int:
    """Plan a joint path from a start to a goal that keeps away from obstacles and singular configurations.

    A start or goal is a name from the scene file, q:0.1,-0.4,... (joints, rad), xyz:0.92,-0.10,0.42 (tool
    position, m) or pose:x,y,z,qx,qy,qz,qw. With no options this is the paper's scenario: a KUKA LBR iiwa 14
    among obstacles. Examples:

    planner plan --beta 0 --seed 3

    planner plan --robot panda --scene shelf --out shelf

    planner plan --start home --goal xyz:0.5,0.3,0.6 --roadmap out/roadmap.npz

    Writes plan.json, plan.html (open it in a browser) and roadmap.npz. Exit code 0: solved; 2: a wrong option;
    3: an unusable robot, scene, state or file; 4: no path within the budget; 130: interrupted.

    Args:
        out: Folder to write into.
        debug: Show tracebacks of errors.
    """
    from planner.files import make_folder, require_writable_folder
    from planner.interrupt import StopRequest

    require_writable_folder(out)
    from planner import plan as planning
    from planner.results import save_plan
    from planner.view.page import write_plan_page

    imported = time.perf_counter() - _STARTED
    with StopRequest() as stop:
        with _progress() as bar:
            result = planning.plan(request, _reporter(bar), stop)
        make_folder(out)
        before_page = time.perf_counter()
        write_plan_page(result, out / "plan.html")
        page = time.perf_counter() - before_page
        timings = {"import": imported, "page": page, "total": time.perf_counter() - _STARTED}
        record = save_plan(result, out, timings)
    _print(_plan_table(record))
    _say(f"{result.outcome.value} Written: {out / 'plan.json'}, {out / 'plan.html'}, {out / 'roadmap.npz'}")
    return result.outcome.exit_code


@app.command
def robots(debug: Flag = False) -> int:
    """List the robots, with their joints and limits.

    Args:
        debug: Show tracebacks of errors.
    """
    from rich.table import Table

    from planner.resources import robot_names
    from planner.robot import Robot

    table = Table("robot", "joint", "from", "to", "unit", "tool frame")
    for name in robot_names():
        robot = Robot.load(name)
        for k, joint in enumerate(robot.joints):
            first = k == 0
            unit = "m" if robot.prismatic[k] else "rad, turns freely" if robot.continuous[k] else "rad"
            table.add_row(
                name if first else "",
                joint,
                f"{robot.lower[k]:.4f}",
                f"{robot.upper[k]:.4f}",
                unit,
                robot.tool if first else "",
            )
        table.add_section()
    _print(table)
    return 0


@app.command
def scenes(debug: Flag = False) -> int:
    """List the scenes, with their obstacles and named states.

    Args:
        debug: Show tracebacks of errors.
    """
    from rich.table import Table

    from planner.resources import scene_names
    from planner.scene import Scene

    table = Table("scene", "description", "obstacles", "robots: named states")
    for name in scene_names():
        scene = Scene.load(name)
        states = "\n".join(f"{robot}: {', '.join(named)}" for robot, named in scene.states.items())
        table.add_row(name, scene.description, _some([o.name for o in scene.obstacles]), states)
        table.add_section()
    _print(table)
    return 0


@app.command
def reproduce(
    what: Annotated[Literal["example", "laws"], tyro.conf.Positional],
    out: Path | None = None,
    seed: int = 0,
    graphs: int = 20,
    debug: Flag = False,
) -> int:
    """Reproduce a simulation of the paper: its figures, its table, and a verdict on each of its sentences.

    'example' is the nine-node graph, 'laws' the comparison of the control laws on random graphs of 500 nodes (section
    4.1). Writes PNG figures and a JSON file with the table and the verdicts; Ctrl-C saves what is done.

    Args:
        what: Which simulation.
        out: Folder to write into; reproduce-WHAT where left out.
        seed: Seed of the random graphs ('laws').
        graphs: Number of random graphs ('laws').
        debug: Show tracebacks of errors.
    """
    from planner.files import require_writable_folder
    from planner.interrupt import StopRequest

    folder = out or Path(f"reproduce-{what}")
    require_writable_folder(folder)
    from planner.experiments.report import write_report

    with StopRequest() as stop, _progress() as bar:
        if what == "example":
            from planner.experiments.example import run_example

            report = run_example()
        else:
            from planner.experiments.laws import run_laws

            report = run_laws(graphs, seed=seed, progress=_reporter(bar), stop=stop)
    written = write_report(report, folder)
    _print(_table(report.table))
    _print(_verdict_table(report.verdicts))
    _say("Written: " + ", ".join(map(str, written)))
    return 0 if report.complete else 130


@app.command
def bench(
    what: Annotated[Literal["gabf"], tyro.conf.Positional],
    out: Path | None = None,
    seed: int = 0,
    sizes: tuple[int, ...] = (1_000, 10_000, 100_000),
    debug: Flag = False,
) -> int:
    """Measure speed, as ratios within one run.

    'gabf' times the dynamics against SciPy's RK45 and scipy.sparse.csgraph.dijkstra on random geometric networks. Rows
    that the folder already holds are not measured again, so an interrupted run goes on where it stopped.

    Args:
        what: Which benchmark.
        out: Folder to write into; bench-WHAT where left out.
        seed: Seed of the networks.
        sizes: Numbers of nodes; 1000000 takes minutes and 1.3 GiB.
        debug: Show tracebacks of errors.
    """
    from planner.files import require_writable_folder
    from planner.interrupt import StopRequest

    folder = out or Path(f"bench-{what}")
    require_writable_folder(folder)
    from planner.benchmark.gabf import bench_gabf
    from planner.benchmark.gabf_rows import to_markdown

    with StopRequest() as stop, _progress() as bar:
        result = bench_gabf(folder, sizes, seed=seed, progress=_reporter(bar), stop=stop)
    _say(to_markdown(result))
    return 0 if result.complete else 130


def main() -> None:
    """Run the command line; every expected error is one sentence on standard error and an exit code."""
    logging.basicConfig(level=logging.WARNING, format="planner: %(message)s", stream=sys.stderr)
    debug = "--debug" in sys.argv[1:]
    try:
        code = app.cli(
            prog="planner",
            description="Singularity-averse path planning for robot arms: proven edges, certified cost-to-go.",
        )
    except PlannerError as error:
        if debug:
            raise
        print(f"planner: error: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        print("planner: interrupted before there was anything to save.", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:
        # the reader of our output has gone, as `planner robots | head` does
        sys.stderr.close()
        sys.exit(0)
    sys.exit(code)


def _table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A report's table as the terminal shows it."""
    from rich.markup import escape
    from rich.table import Table

    from planner.experiments.report import text_table

    columns, lines = text_table(tuple(rows))
    table = Table(*columns)
    for line in lines:
        table.add_row(*map(escape, line))
    return table


def _verdict_table(verdicts: Sequence[Verdict]) -> Table:
    from rich.markup import escape
    from rich.table import Table

    table = Table("the paper says", "confirmed", "note", show_lines=True)
    for verdict in verdicts:
        table.add_row(*map(escape, (verdict.sentence, f"{verdict.confirmed} of {verdict.of}", verdict.note)))
    return table


def _some(names: list[str], most: int = 8) -> str:
    """The first few of a list, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return (", ".join(names[:most]) or "none") + more


def _say(text: str) -> None:
    print(text)


def _print(renderable: Any) -> None:
    from rich.console import Console

    Console(soft_wrap=not sys.stdout.isatty()).print(renderable)


def _progress() -> Progress:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description:10}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=Console(stderr=True))


def _reporter(bar: Progress) -> Callable[[str, int, int], None]:
    tasks: dict[str, Any] = {}

    def report(stage: str, done: int, total: int) -> None:
        if stage not in tasks:
            tasks[stage] = bar.add_task(stage, total=total)
        bar.update(tasks[stage], completed=min(done, total), total=total)

    return report


def _plan_table(record: dict[str, Any]) -> Table:
    from rich.markup import escape
    from rich.table import Table

    from planner.results import summary_rows

    table = Table("", "", title=escape(f"{record['robot']} in {record['scene']}"), show_header=False)
    for name, value in summary_rows(record):
        table.add_row(name, escape(value))
    table.add_row("seconds", ", ".join(f"{stage} {value:.2f}" for stage, value in record["timings_s"].items()))
    return table
