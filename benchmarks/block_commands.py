"""``benchmarks scaling|partition|stale``: more processes for a batch, and for one network."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.terminal import measure
from planner.cli.common import Debug, Out
from planner.problem.request import PlanRequest


def scaling(
    source: tyro.conf.Positional[Path],
    request: Annotated[PlanRequest, tyro.conf.arg(name="")] = PlanRequest(),  # noqa: B008 (frozen)
    out: Out = Path("bench-scaling"),
    jobs: tuple[int, ...] = (),
    scheduler: str | None = None,
    debug: Debug = False,
) -> int:
    """A batch by one to all cores: how much sooner it is done, and a model of 10,000 problems on 1, 10, 100 workers.

    SOURCE and the options of plans are those of 'planner batch'. Writes scaling.csv and scaling.md.

    Args:
        source: The plans: a .yaml or .csv file, or a folder.
        jobs: Numbers of jobs to measure; from 1 to all cores where none is given.
        scheduler: Address of a Dask cluster to measure too, with the last number of jobs.
    """
    from benchmarks.scaling.run import bench_scaling

    return measure(out, lambda progress: bench_scaling(source, out, request, jobs, scheduler, progress))


def partition(
    out: Out = Path("bench-partition"),
    arcs: tuple[int, ...] = (100_000, 1_000_000),
    blocks: int = 2,
    steps: int = 300_000,
    seed: int = 0,
    debug: Debug = False,
) -> int:
    """The dynamics on a network cut into blocks, here and on Dask actors, against one process and Dijkstra.

    Writes partition.csv and partition.md: seconds, memory, and what the blocks exchange.

    Args:
        arcs: Arcs of the networks, about; 10000000 takes many minutes and 5 GiB.
        blocks: Blocks, and processes of the cluster.
        steps: Steps of the dynamics at most: a few tell what one step costs.
        seed: Seed of the networks.
    """
    from benchmarks.partition.run import bench_partition

    return measure(out, lambda progress: bench_partition(out, arcs, blocks, steps, seed, progress))


def stale(out: Out = Path("bench-stale"), graphs: int = 10, seed: int = 0, debug: Debug = False) -> int:
    """Blocks that read old values of each other: whether the dynamics still ends at x*, and how much later.

    Writes stale.csv and stale.md.

    Args:
        graphs: Networks for each law, start and age of values.
        seed: Seed of the networks.
    """
    from benchmarks.partition.stale import bench_stale

    return measure(out, lambda progress: bench_stale(out, graphs, seed, progress))
