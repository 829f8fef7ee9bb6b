"""``planner sweep``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from planner.base.errors import OptionError
from planner.base.interrupts import leaving_on_interrupt
from planner.cli.common import Debug, Flag, Out, Workers, command_clock
from planner.cli.terminal import report_table, run_into, say, show, working
from planner.problem.request import SERIAL, SweepRequest, WorkersRequest

if TYPE_CHECKING:
    from planner.tradeoff.sweep import Tradeoff


def sweep(
    request: Annotated[SweepRequest, tyro.conf.arg(name="")] = SweepRequest(),  # noqa: B008 (frozen)
    front: Flag = False,
    max_labels: int | None = None,
    resume: Flag = False,
    seeds: tuple[int, ...] = (),
    out: Out = Path("sweep"),
    workers: Workers = SERIAL,
    debug: Debug = False,
) -> int:
    """The whole trade-off between manipulability and distance: every path that some beta makes optimal.

    Finds all values of beta at which the best path changes, exactly and without a grid, on one roadmap. Starts,
    goals and all other options are those of 'planner plan'. Examples:

    planner sweep --seed 3

    planner sweep --roadmap out/roadmap.npz --front

    planner sweep --nodes 20000 --out big; planner sweep --nodes 20000 --out big --resume

    Writes sweep.json, sweep.csv, sweep.html (open it in a browser) and roadmap.npz. Exit codes are those of
    'planner plan'; Ctrl-C saves what is proven so far, without the page, and --resume goes on from there. Where --out
    holds another sweep already that is kept, and the interrupted one goes into the folder 'interrupted' inside it
    ('interrupted-2' and so on where that is taken).

    With --seeds there is one sweep per seed, in the folder seed-K of --out, and a row each in seeds.csv; --jobs of them
    at once. Run again, the same command sweeps what is missing.

    planner sweep --seeds 0 1 2 3 --jobs 2

    Args:
        front: Find the paths too that no beta can reach: all that are not worse in both costs than another one.
        max_labels: Partial paths that the search of --front may make, 1000000 where left out; it says so if it was
            stopped there.
        resume: Go on from the sweep in --out, which must be of the same options.
        seeds: Seeds to sweep with, in place of --seed.
    """
    from planner.base.files import require_writable_folder

    if max_labels is not None and not front:
        raise OptionError("--max-labels limits the search of --front: give --front too, or leave it out.")
    _require_one_or_many(request, resume, seeds, workers)
    require_writable_folder(out)
    if seeds:
        return _many(request, seeds, out, front, max_labels, workers)
    from planner.cli.interrupted import folder_for_interrupted, kept
    from planner.problem.outcome import Outcome
    from planner.tradeoff.nondominated import MAX_LABELS
    from planner.tradeoff.record import NAMES, PAGE_NAME, read_checkpoint, save_sweep_page, save_sweep_without_page
    from planner.tradeoff.sweep import sweep as find_tradeoff

    clock = command_clock()
    labels = MAX_LABELS if max_labels is None else max_labels
    earlier = read_checkpoint(request, out) if resume else None
    with working() as progress:
        result = find_tradeoff(request, progress, front, labels, earlier)
        interrupted = result.outcome is Outcome.INTERRUPTED
        place = folder_for_interrupted(out, NAMES, resume) if interrupted else out
        record = save_sweep_without_page(result, place, clock)
        written = [str(place / name) for name in NAMES if name != PAGE_NAME]
        said = f"{_ending(result, place)} Written: {', '.join(written)}"
        with leaving_on_interrupt(f"stopping without the page. {said}"):
            if not progress.stopped:
                record = save_sweep_page(result, place, record, clock)
                said = f"{_ending(result, place)} Written: {', '.join(str(place / name) for name in NAMES)}"
    _tell(record, said + kept(out, place))
    return Outcome.INTERRUPTED.exit_code if progress.stopped else result.outcome.exit_code


def _require_one_or_many(request: SweepRequest, resume: bool, seeds: tuple[int, ...], workers: WorkersRequest) -> None:
    if seeds and (resume or request.seed != SweepRequest().seed):
        raise OptionError("--seeds goes on by itself and takes the place of --seed: leave --resume and --seed out.")
    if not seeds and workers != SERIAL:
        raise OptionError("--jobs, --backend and --scheduler are for several sweeps: give --seeds too.")


def _many(
    request: SweepRequest,
    seeds: tuple[int, ...],
    out: Path,
    front: bool,
    max_labels: int | None,
    workers: WorkersRequest,
) -> int:
    from planner.batch.sweep_seeds import sweep_seeds
    from planner.problem.outcome import Outcome
    from planner.tradeoff.nondominated import MAX_LABELS

    labels = MAX_LABELS if max_labels is None else max_labels
    found = run_into(
        out, lambda progress: sweep_seeds(request, seeds, out, front, labels, progress=progress, workers=workers)
    )
    say(found.report)
    if not found.complete:
        return Outcome.INTERRUPTED.exit_code
    return 0 if all(row.outcome == Outcome.SOLVED.key for row in found.rows) else Outcome.NO_PATH.exit_code


def _tell(record: dict[str, Any], said: str) -> None:
    from planner.tradeoff.record import interval_rows, summary_lines

    if record["intervals"]:
        show(report_table(interval_rows(record)))
    for line in summary_lines(record):
        say(line)
    say("Seconds: " + ", ".join(f"{stage} {value:.2f}" for stage, value in record["timings_s"].items()) + ".")
    say(said)


def _ending(result: Tradeoff, place: Path) -> str:
    from planner.problem.outcome import Outcome

    match result.outcome:
        case Outcome.SOLVED:
            count = len(result.intervals)
            return f"{count} path{'s are' if count != 1 else ' is'} optimal, each in its interval of beta."
        case Outcome.INTERRUPTED if result.grown:
            return f"{result.outcome.value} --out {place} --resume goes on from there."
        case Outcome.INTERRUPTED:
            return f"{result.outcome.value} The roadmap was not whole yet: --out {place} --resume grows it anew."
        case _:
            return result.outcome.value
