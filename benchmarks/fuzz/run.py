"""``benchmarks fuzz``: changed files of every kind end in success or one sentence, never otherwise.

Cases run in processes of their own, many to a process: a native parser that crashes takes one process with it, which
is counted as a failure of the case it was at. The parent starts the next one behind it.
"""

from __future__ import annotations

import json
import logging
import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.fuzz.cases import FileKind, kinds
from planner.base.errors import OptionError, PlannerError, choices
from planner.base.files import make_folder, write_whole
from planner.base.progress import QUIET, Progress
from planner.base.silenced import Silenced
from planner.base.tables import markdown_table
from planner.problem.request import require_seed
from planner.processes.process import Ended, run_module

_BATCH = 200  # cases a process
_SECONDS = 20.0  # a case may take, and a process has for its start: far from what a loaded machine needs
_MEMORY = 4 << 30  # bytes a process may have
_LONGEST = 2000  # characters of a sentence


@dataclass(frozen=True)
class Case:
    """What became of one case: ``ended`` is "loaded", "refused", or what is wrong with how it ended."""

    kind: str
    number: int
    ended: str
    text: str = ""

    @property
    def failed(self) -> bool:
        return self.ended not in ("loaded", "refused")


@dataclass(frozen=True)
class FuzzBench:
    """All cases; ``complete`` is False where it was interrupted."""

    seed: int
    cases: tuple[Case, ...]
    complete: bool

    @property
    def failures(self) -> tuple[Case, ...]:
        return tuple(case for case in self.cases if case.failed)

    @property
    def report(self) -> str:
        """Counts of each kind of file, and every failure, as Markdown."""
        return _to_markdown(self)


def bench_fuzz(
    folder: Path,
    cases: int = 2000,
    seed: int = 0,
    only: Sequence[str] = (),
    progress: Progress = QUIET,
) -> FuzzBench:
    """Change files ``cases`` times, kind after kind, and load them; write ``fuzz.md`` and the files that failed.

    The same seed makes the same files. Raises OptionError for numbers or kinds that make no sense.
    """
    require_seed(seed)
    names = tuple(only) or tuple(kinds())
    unknown = [name for name in names if name not in kinds()]
    if unknown or not 1 <= cases <= 10_000_000:
        what = f"kind '{unknown[0]}'" if unknown else f"{cases} cases"
        raise OptionError(f"{what} cannot be fuzzed: give a number from 1 to 10000000; kinds are {choices(kinds())}.")
    make_folder(folder)
    found: list[Case] = []
    while len(found) < cases and not progress.stopped:
        found += _batch(seed, names, len(found), min(cases, len(found) + _BATCH), progress)
        progress("files", len(found), cases)
    result = FuzzBench(seed, tuple(found), len(found) >= cases)
    for case in result.failures:
        kind = kinds()[case.kind]
        write_whole(
            folder / f"{case.kind.replace(' ', '-')}-{seed}-{case.number}{kind.suffix}", make(seed, case.number, kind)
        )
    write_whole(folder / "fuzz.md", result.report.encode())
    return result


def make(seed: int, number: int, kind: FileKind) -> bytes:
    """The changed file of a case."""
    return kind.make(np.random.default_rng([seed, number]))


def judge(use: Callable[[Path], object], path: Path) -> tuple[str, str]:
    """How a use of the file at ``path`` ends: "loaded", "refused", or what is wrong with it; and a text about it."""
    ended, text = "loaded", ""
    begin = time.perf_counter()
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("default")
        with Silenced() as printed:
            try:
                use(path)
            except PlannerError as error:
                ended, text = "refused", str(error)
            except Exception as error:  # whatever it is, it would have reached a user
                ended, text = type(error).__name__, str(error)[:500]
    if ended == "refused" and ("\n" in text or not text.endswith((".", "?", "!")) or len(text) > _LONGEST):
        ended = "no one sentence"
    shown = printed.text + "".join(f"{item.category.__name__}: {item.message}" for item in warned)
    if shown and ended in ("loaded", "refused"):
        ended, text = "printed", shown[:500]
    if time.perf_counter() - begin > _SECONDS and ended in ("loaded", "refused"):
        ended = "slow"
    return ended, text


def _to_markdown(result: FuzzBench) -> str:
    lines = []
    for name in dict.fromkeys(case.kind for case in result.cases):
        mine = [case for case in result.cases if case.kind == name]
        counts = [sum(case.ended == ended for case in mine) for ended in ("loaded", "refused")]
        lines.append([name, len(mine), *counts, len(mine) - sum(counts)])
    table = markdown_table(["file", "cases", "loaded", "refused with a sentence", "failures"], lines)
    wrong = [f"- {case.kind} {case.number}: {case.ended}: {case.text!r}" for case in result.failures]
    ending = [] if result.complete else ["", "Interrupted: the cases that were not tried are missing above."]
    return "\n".join([*table, "", f"Seed {result.seed}.", *wrong, *ending]) + "\n"


def _batch(seed: int, names: Sequence[str], first: int, last: int, progress: Progress) -> list[Case]:
    """The cases of one process: all of [first, last), or up to the one that it did not survive."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "cases.jsonl"
        arguments = [str(seed), str(first), str(last), str(out), *names]
        ended: Ended = run_module("benchmarks.fuzz.run", arguments, progress, _SECONDS * (2 + 0.1 * (last - first)))
        lines = out.read_text("utf-8").splitlines() if out.exists() else []
    found = [Case(**json.loads(line)) for line in lines]
    if ended.code == 1:  # Python ended it outside of a case
        raise PlannerError(f"a fuzzing process ended by itself ({ended.last_words}): this is a fault of the fuzzer.")
    if len(found) < last - first and not progress.stopped:
        number = first + len(found)
        how = "hangs" if ended.over_time else f"process ended with {ended.code}"
        found.append(Case(names[number % len(names)], number, how, ended.last_words))
    return found


def _main(seed: int, first: int, last: int, out: Path, names: Sequence[str]) -> None:
    """Try the cases [first, last) and write a line each."""
    logging.getLogger("planner").addHandler(logging.NullHandler())
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))  # what asks for more is not to take the machine with it
    with out.open("a", encoding="utf-8") as file, tempfile.TemporaryDirectory() as folder:
        for number in range(first, last):
            name = names[number % len(names)]
            kind = kinds()[name]
            path = Path(folder) / f"file{kind.suffix}"
            path.write_bytes(make(seed, number, kind))
            ended, text = judge(kind.use, path)
            file.write(json.dumps(asdict(Case(name, number, ended, text))) + "\n")
            file.flush()


if __name__ == "__main__":
    _main(int(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]), sys.argv[5:])
