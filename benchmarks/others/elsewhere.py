"""A script run by the Python of another environment, for planners whose needs clash with ours."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from planner.base.errors import OptionError, PlannerError

ROBOPLAN, HPP = PLANNERS = ("roboplan", "hpp")


def environments(given: Sequence[str]) -> dict[str, str]:
    """The path of each Python by the name of its planner, out of NAME=PATH; :class:`OptionError` for other text."""
    found = {}
    for text in given:
        name, _, path = text.partition("=")
        if name not in PLANNERS or not Path(path).is_file():
            raise OptionError(
                f"python '{text[:200]}' is not usable: give NAME=PATH, a planner of {', '.join(PLANNERS)} and the "
                "Python of the environment that it is installed in, such as roboplan=/opt/roboplan/bin/python."
            )
        found[name] = path
    return found


def answer_of(
    name: str, python: str, script: str, problem: dict[str, Any], wait: float, words: Sequence[str] = ()
) -> Any:
    """What ``python -I script *words PROBLEM ANSWER`` writes to ANSWER within ``wait`` s; both files are JSON.

    ``name`` is that of what is asked there. Raises :class:`PlannerError` where it does not answer, or fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        asked, answer = Path(folder) / "problem.json", Path(folder) / "answer.json"
        asked.write_text(json.dumps(problem))
        command = [python, "-I", script, *words, str(asked), str(answer)]
        try:
            ended = subprocess.run(
                command, capture_output=True, text=True, timeout=wait, check=False, env=_environment(python)
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise PlannerError(f"{python} did not answer: {error}.") from None
        if ended.returncode:
            said = ended.stderr.strip().splitlines() or [f"exit code {ended.returncode}"]
            raise PlannerError(f"{name} in {python}: {said[-1]}")
        return json.loads(answer.read_text())


def _environment(python: str) -> dict[str, str]:
    """The variables for a Python; the modules of some wheels (HPP's) do not know where their own libraries lie."""
    libraries = Path(python).absolute().parent.parent.glob("lib/python3*/site-packages/cmeel.prefix/lib")
    paths = [*map(str, libraries), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
    return {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(paths)} if paths else {**os.environ}
