"""One method on one network, in a process of its own: seconds, memory, and what was told between blocks.

python -m benchmarks.partition.case network.npz row.json '{"method": "actors", "blocks": 2, "steps": 100}'
"""

from __future__ import annotations

import hashlib
import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.gabf.case import KERNEL, LAW, dijkstra_on
from benchmarks.memory import peak_memory
from planner import gabf
from planner.base.cluster import cluster, local_cluster
from planner.base.files import write_whole

WHOLE, HERE, ACTORS, DIJKSTRA = "one process", "blocks here", "actors", "dijkstra"
METHODS = (WHOLE, HERE, ACTORS, DIJKSTRA)


def measure(path: Path, method: str, blocks: int, steps: int) -> dict[str, Any]:
    """The columns of one method; memory (MiB) is the most that this process, and each worker, has held."""
    begin = time.perf_counter()
    network = gabf.read_network(path, KERNEL)
    facts: dict[str, Any] = {"load_s": time.perf_counter() - begin, "load_mib": peak_memory()}
    if method == ACTORS:
        with local_cluster(blocks) as scheduler:
            facts |= _solved(network, gabf.Partition(blocks, scheduler), steps)
            with cluster(scheduler) as found:
                facts["worker_mib"] = max(found.on_each(peak_memory))
    elif method == DIJKSTRA:
        search = dijkstra_on(network)
        begin = time.perf_counter()
        facts["x"] = search()
        facts["solve_s"] = time.perf_counter() - begin
    else:
        facts |= _solved(network, gabf.Partition(blocks) if method == HERE else None, steps)
    digest = hashlib.sha256(np.ascontiguousarray(facts.pop("x")).tobytes()).hexdigest()[:16]
    return facts | {"x_sha256": digest, "mib": peak_memory()}


def _solved(network: gabf.Network, partition: gabf.Partition | None, steps: int) -> dict[str, Any]:
    """A run of at most ``steps`` steps; ``prepare_s``: a run without steps, blocks made and sent included.

    A run before both loads and makes what any later one finds: it is not counted.
    """
    seconds = []
    for most in (0, 0, steps):
        begin = time.perf_counter()
        found = gabf.solve(replace(network), LAW, partition=partition, max_steps=most)
        seconds.append(time.perf_counter() - begin)
    facts = {"x": found.x, "prepare_s": seconds[1], "solve_s": seconds[2], "steps": found.steps}
    facts["settled"] = found.outcome is gabf.Ending.SETTLED
    if found.exchanged is not None:
        facts |= {"boundary": found.exchanged.boundary, "told": found.exchanged.states, "calls": found.exchanged.calls}
    return facts


def main(network: str, out: str, options: str) -> None:
    """What the process does."""
    write_whole(Path(out), json.dumps(measure(Path(network), **json.loads(options))).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
