"""The command line: typed functions are the commands, and their docstrings the help."""

import logging
import sys
import time
from collections.abc import Callable
from typing import NoReturn

from planner.base.errors import LOGGER, PlannerError
from planner.cli.terminal import complain, release_output

STARTED = time.perf_counter()


def main() -> None:
    """Run the command line of the planner."""
    from planner.cli import app

    run_and_exit(app.run)


def run_and_exit(run: Callable[[list[str]], int]) -> NoReturn:
    """Exit with the code of ``run(words)``; an expected error is one sentence on standard error."""
    lines = logging.StreamHandler(sys.stderr)
    lines.setFormatter(logging.Formatter("planner: %(message)s"))
    logging.basicConfig(level=logging.WARNING, handlers=[lines])
    logging.getLogger(LOGGER).setLevel(logging.DEBUG)
    try:
        code = run(sys.argv[1:])
    except BrokenPipeError:  # `planner robots | head` closes our output
        release_output()
        code = 0
    except (PlannerError, MemoryError, ImportError, OSError, RuntimeError) as error:
        sentence = _sentence(error)
        if "--debug" in sys.argv or sentence is None:
            raise
        complain(f"error: {sentence}")
        release_output()
        code = error.exit_code if isinstance(error, PlannerError) else PlannerError.exit_code
    sys.exit(code)


def _sentence(error: Exception) -> str | None:
    """Return the sentence of an error, with a remedy for errors of the system; None for a bug."""
    if isinstance(error, PlannerError):
        return str(error)
    if isinstance(error, ImportError):
        return f"a library cannot be loaded ({error}): install it again, or raise the memory limit (ulimit -v)."
    if isinstance(error, OSError):
        place = "" if error.filename is None else f" at {error.filename}"
        return f"the system reports an error{place}: {error.strerror or error}; free space or choose another place."
    if isinstance(error, MemoryError) or "can't start new thread" in str(error):  # a thread wants 8 MiB
        return "the memory is exhausted: plan with fewer nodes, or raise the memory limit (ulimit -v)."
    return None
