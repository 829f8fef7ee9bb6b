"""The command line: typed functions are the commands, their docstrings the help; one file a command.

Importing it loads nothing heavy, so that ``planner --help`` is quick.
"""

from __future__ import annotations

import importlib.metadata
import logging
import sys

import tyro

from planner.base.errors import PlannerError
from planner.cli.arguments import prepared
from planner.cli.bench import bench
from planner.cli.catalogue import robots, scenes
from planner.cli.check import check
from planner.cli.plan import plan
from planner.cli.reproduce import reproduce
from planner.cli.roadmap import roadmap
from planner.cli.sweep import sweep
from planner.cli.terminal import complain, say
from planner.cli.view import view

app = tyro.extras.SubcommandApp()
app.command(plan)
app.command(sweep)
app.command(view)
app.command(check)
app.command(robots)
app.command(scenes)
app.command(roadmap, name="roadmap")
app.command(reproduce, name="reproduce")
app.command(bench, name="bench")


def main() -> None:
    """Run the command line; every expected error is one sentence on standard error and an exit code."""
    logging.basicConfig(level=logging.WARNING, format="planner: %(message)s", stream=sys.stderr)
    debug = "--debug" in sys.argv[1:]
    try:
        arguments = prepared(sys.argv[1:])
        if arguments == ["--version"]:
            say(f"gabf-planner {importlib.metadata.version('gabf-planner')}")
            sys.exit(0)
        code = app.cli(
            prog="planner",
            description="Singularity-averse path planning for robot arms: proven edges, certified cost-to-go. "
            "'planner --version' says which this is.",
            args=arguments,
        )
    except PlannerError as error:
        if debug:
            raise
        complain(f"error: {error}")
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        complain("interrupted before there was anything to save.")
        sys.exit(130)
    except BrokenPipeError:
        # the reader of our output has gone, as `planner robots | head` does
        sys.stderr.close()
        sys.exit(0)
    sys.exit(code)
