"""How a run ended, as the sentence that the user reads."""

from enum import Enum


class Outcome(Enum):
    """An ending that is part of normal life; wrong input raises a :class:`~planner.base.errors.PlannerError` instead.

    ``name.lower()`` is what ``plan.json`` holds, the value is the sentence with the remedy.
    """

    SOLVED = "A collision-free path was found."
    NO_PATH = (
        "Start and goal were not connected within the budget: raise --nodes, try another --seed, "
        "or look at the roadmap in the page to see where it stops."
    )
    TOO_SINGULAR = (
        "No path above the manipulability floor was found within the budget: lower --min-manipulability, "
        "raise --nodes, or try another --seed."
    )
    PARTLY_FOLLOWED = (
        "The tool path could be followed in part only: move it, widen its tube, or let the tool turn about its axis."
    )
    INTERRUPTED = "Interrupted: this is what was done so far."

    @property
    def key(self) -> str:
        return self.name.lower()

    @property
    def exit_code(self) -> int:
        """What a command that ends so exits with."""
        return {
            Outcome.SOLVED: 0,
            Outcome.NO_PATH: 4,
            Outcome.TOO_SINGULAR: 4,
            Outcome.PARTLY_FOLLOWED: 4,
            Outcome.INTERRUPTED: 130,
        }[self]
