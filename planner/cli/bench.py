"""``planner bench``: measurements, as ratios within one run."""

from __future__ import annotations

from pathlib import Path

import tyro

from planner.cli.common import Flag
from planner.cli.terminal import progress, reporter, say

bench = tyro.extras.SubcommandApp()
bench.__doc__ = """Measure success, safety and speed; speed as ratios within one run.

Rows that the folder already holds are not measured again, so an interrupted run goes on where it stopped.
"""


@bench.command
def gabf(
    out: Path = Path("bench-gabf"),
    seed: int = 0,
    sizes: tuple[int, ...] = (1_000, 10_000, 100_000),
    debug: Flag = False,
) -> int:
    """The dynamics against SciPy's RK45 and scipy.sparse.csgraph.dijkstra on random geometric networks.

    Args:
        out: Folder to write into.
        seed: Seed of the networks.
        sizes: Numbers of nodes; 1000000 takes minutes and 1.3 GiB.
        debug: Show tracebacks of errors.
    """
    from planner.files import require_writable_folder
    from planner.interrupt import StopRequest

    require_writable_folder(out)
    from planner.benchmark.gabf import bench_gabf
    from planner.benchmark.gabf_rows import to_markdown

    with StopRequest() as stop, progress() as bar:
        result = bench_gabf(out, sizes, seed=seed, progress=reporter(bar), stop=stop)
    say(to_markdown(result))
    return 0 if result.complete else 130
