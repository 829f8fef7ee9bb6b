"""All commands of the command line, with the help over all of them."""

from __future__ import annotations

import tyro

from planner.cli.batch import batch
from planner.cli.catalogue import robots, scenes
from planner.cli.check import check
from planner.cli.export import export
from planner.cli.plan import plan
from planner.cli.reproduce import reproduce
from planner.cli.roadmap import roadmap
from planner.cli.robot_yaml import robot_yaml
from planner.cli.schema import schema
from planner.cli.sweep import sweep
from planner.cli.view import view

app = tyro.extras.SubcommandApp()
app.command(plan)
app.command(sweep)
app.command(batch)
app.command(view)
app.command(check)
app.command(schema)
app.command(export)
app.command(robots)
app.command(scenes)
app.command(name="robot-yaml")(robot_yaml)
app.command(roadmap, name="roadmap")
app.command(reproduce, name="reproduce")


def run(arguments: list[str]) -> int:
    """The exit code of the command that ``arguments`` ask for; help and what is wrong with them ends the process."""
    return app.cli(
        prog="planner",
        description="Singularity-averse path planning for robot arms: proven edges, certified cost-to-go. "
        "'planner --version' says which this is.",
        args=arguments,
    )
