"""The command line's words before they are read: goals and what is kept may be given several times, others once."""

from __future__ import annotations

from collections.abc import Sequence

from planner.base.errors import OptionError
from planner.problem.targets import AND

_SEVERAL = ("--goal", "--keep")


def prepared(words: Sequence[str]) -> list[str]:
    """The words with all ``--goal`` made one, which stands where the first stood, and all ``--keep``; others twice are
    refused, and what is empty.

    Of an option given twice the parser would take the last and say nothing, and an empty folder is the one that the
    shell stands in. Raises :class:`OptionError`.
    """
    for before, word in zip(("", *words), words, strict=False):
        if not word or (word.startswith("--") and word.find("=") == len(word) - 1):
            of = word[:-1] or (before if before.startswith("--") else "a word")
            raise OptionError(f"{of} is empty: give a value, or leave it out.")
    seen: set[str] = set()
    out: list[str] = []
    first: dict[str, int] = {}  # where the first value of these stands in ``out``
    waiting = iter(words)
    for word in waiting:
        option, equals, value = word.partition("=")
        option = option.replace("_", "-")
        if not option.startswith("--") or option == "--":
            out.append(word)
        elif option in _SEVERAL:
            value = value if equals else next(waiting, None)
            if value is None:
                out.append(option)
            elif option not in first:
                first[option] = len(out) + 1
                out += [option, value]
            else:
                out[first[option]] += AND + value
        elif option in seen:
            raise OptionError(f"option {option} is given twice: give it once.")
        else:
            seen.add(option)
            out.append(word)
    return out
