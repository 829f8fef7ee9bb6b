"""Published numbers."""

from __future__ import annotations

from benchmarks.tables.published import GCS, GCS_TASKS, PUBLISHED


def test_every_task_has_its_published_numbers() -> None:
    for start, goal in GCS_TASKS:
        of = [one for one in PUBLISHED if (one.table, one.task) == (GCS, f"{start} to {goal}")]
        assert [one.method for one in of] == ["GCS", "PRM", "PRM, shortcuts"]
        assert of[0].length_rad < of[2].length_rad < of[1].length_rad
    assert GCS_TASKS[0][0] == GCS_TASKS[-1][1]
