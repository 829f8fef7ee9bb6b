"""A function called in a process of its own.

Call and answer pass through a folder that only the two processes see, and that is gone afterwards; nothing pickled is
ever kept or read from elsewhere. python -m planner.processes.apart FOLDER
"""

from __future__ import annotations

import pickle
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from planner.base.errors import PlannerError
from planner.base.progress import QUIET, Progress
from planner.processes.process import run_module

_CALL, _ANSWER = "call", "answer"


def call_apart(function: Callable[[Any, Progress], Any], case: Any, progress: Progress) -> Any:
    """``function(case, QUIET)`` from a fresh process, or None where ``progress`` was stopped before it ended.

    Errors of the planner are raised here as they were there. A process that somebody kills is started once more;
    PlannerError if that one ends without an answer too.
    """
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / _CALL).write_bytes(pickle.dumps((function, case)))
        ended = run_module("planner.processes.apart", [folder], progress, tries=2)
        if ended.code is None:
            return None
        if ended.code != 0:
            raise PlannerError(f"a process ended with code {ended.code}: {ended.last_words or 'it was killed'}.")
        found = pickle.loads((Path(folder) / _ANSWER).read_bytes())
    if isinstance(found, PlannerError):
        raise found
    return found


def _main(folder: Path) -> None:
    function, case = pickle.loads((folder / _CALL).read_bytes())
    try:
        found = function(case, QUIET)
    except PlannerError as error:
        found = error
    (folder / _ANSWER).write_bytes(pickle.dumps(found))


if __name__ == "__main__":
    _main(Path(sys.argv[1]))
