"""The highest floor that a roadmap's paths keep to, against the widest path by another algorithm."""

from __future__ import annotations

from planner.planning.conditioning import reachable_floor
from planner.planning.plan import plan
from planner.planning.why_no_path import highest_floor
from planner.problem.request import PlanRequest
from planner.roadmap.storage import save_roadmap
from planner.search.manipulability_floor import first_violation
from tests.worlds import checker_of, post_roadmap, small_plan


def test_below_both_ends_it_is_the_widest_path(tmp_path) -> None:
    """Where the floor lies below the w of both ends, a path keeps to it if all of its w do: a bottleneck."""
    found = small_plan()
    widest = reachable_floor(found.robot, found.roadmap)
    ends = found.roadmap.manipulability[[*found.roadmap.starts, *found.roadmap.goals]]
    asked = float(ends.min())
    highest = highest_floor(found.roadmap, found.checker, found.request.with_options(min_manipulability=asked).quality)
    assert 0.85 * min(widest, asked) < highest < asked
    save_roadmap(found.roadmap, tmp_path / "kept.npz")
    again = plan(
        PlanRequest.from_options(nodes=150, roadmap=tmp_path / "kept.npz", min_manipulability=highest, effort=0)
    )
    assert len(again.path)
    assert first_violation(again.robot, again.path, highest) is None


def test_a_floor_above_all_w_tells_what_one_at_the_highest_w_does() -> None:
    """What a path is found to keep to does not hang on how far above all w the floor was that was asked for."""
    found = small_plan()
    top = float(found.roadmap.edge_manipulability.max())
    asked = (found.request.with_options(min_manipulability=floor) for floor in (top, 1000.0 * top))
    near, far = (highest_floor(found.roadmap, found.checker, request.quality) for request in asked)
    assert far == near > 0.0


def test_it_is_none_where_every_path_passes_zero() -> None:
    """The post's start and goal have q2 of opposite signs."""
    request = PlanRequest.from_options(min_manipulability=0.1)
    checker = checker_of("planar_2r")
    assert highest_floor(post_roadmap(), checker, request.quality) == 0.0
