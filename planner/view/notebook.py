"""Pages in a notebook cell. By themselves results show a small table, which keeps a committed notebook small."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Protocol

from planner.base.errors import OptionError
from planner.collision.checker import CollisionChecker
from planner.roadmap.roadmap import Roadmap
from planner.view.page import roadmap_page


class HasPage(Protocol):
    """A plan, a trade-off: whatever can draw its page as HTML text."""

    def page(self) -> str: ...


@dataclass(frozen=True, repr=False)
class InlinePage:
    """A page as a notebook cell shows it, ``height`` pixels high."""

    html: str
    height: int

    def _repr_html_(self) -> str:
        # no allow-same-origin: what a scene file was named cannot reach the notebook
        style = f"width:100%;height:{self.height}px;border:0"
        return f'<iframe sandbox="allow-scripts" style="{style}" srcdoc="{escape(self.html)}"></iframe>'

    def __repr__(self) -> str:
        return f"<page of {len(self.html) / 1e6:.1f} MB>"


def show(thing: HasPage | Roadmap, checker: CollisionChecker | None = None, height: int = 640) -> InlinePage:
    """The interactive page of a plan or a trade-off in a notebook cell; of a roadmap, with the checker of its world.

        planner.show(plan)
        planner.show(roadmap, checker)

    Raises :class:`OptionError` for a roadmap alone, or with a checker of another robot, and for what has a checker of
    its own beside another.
    """
    if isinstance(height, bool) or height < 1:
        raise OptionError(f"height is {height}: give a whole number of pixels above 0.")
    if isinstance(thing, Roadmap):
        if checker is None:
            raise OptionError(
                "a roadmap holds no geometry: give the checker it was grown with, show(roadmap, checker)."
            )
        if thing.origin.joints != checker.robot.joints:
            raise OptionError(
                f"the roadmap is of {thing.origin.robot}, the checker of {checker.robot.name}: give the checker that "
                "the roadmap was grown with."
            )
        return InlinePage(roadmap_page(thing, checker), height)
    if checker is not None:
        raise OptionError("a plan or trade-off is shown with the checker it was made with: leave the other one out.")
    return InlinePage(thing.page(), height)
