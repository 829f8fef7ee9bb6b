"""``python -m benchmarks``: the commands of all benchmarks."""

from __future__ import annotations

import tyro

from benchmarks.attack.run import attack
from benchmarks.cells import cells
from benchmarks.clouds import clouds
from benchmarks.first_motion.run import first_motion
from benchmarks.gabf.run import gabf
from benchmarks.gate.run import gate
from benchmarks.optimum.run import optimum
from benchmarks.plan.run import plan
from benchmarks.roadmap.run import roadmap
from benchmarks.tables.run import tables
from benchmarks.tasks.run import tasks
from benchmarks.tool_paths.run import tool_paths
from benchmarks.tradeoff.run import tradeoff
from planner.cli.app import registry

bench = tyro.extras.SubcommandApp()
ALL = (plan, first_motion, clouds, cells, attack, gabf, gate, roadmap, optimum, tool_paths, tasks, tables)
for command in (*ALL, tradeoff):
    bench.command(command)


def run(arguments: list[str]) -> int:
    """The exit code of the benchmark that ``arguments`` ask for; help and what is wrong with them ends the process."""
    with registry:
        return bench.cli(
            prog="python -m benchmarks",
            description="Measure success, safety and speed; speed as ratios within one run. Rows that the folder "
            "already holds are not measured again, so an interrupted run goes on where it stopped.",
            args=arguments,
            config=(tyro.conf.OmitArgPrefixes,),
        )
