"""What the benchmark of first motions says."""

from __future__ import annotations

from typing import Any

from benchmarks.first_motion.report import OMPL, OURS, ROBOPLAN, WHOLE, Row, aims, to_markdown
from planner.batch.outcomes import NO_PATH, SOLVED

TIMED: dict[str, Any] = {
    "motion_s": 0.012,
    "total_s": 0.03,
    "motion_contact": "",
    "largest_share": 0.999,
    "proven": True,
}


def row(problem: str, method: str, outcome: Any = SOLVED, **more: Any) -> Row:
    asked = (problem, method, 0, "panda", "coal", "slowly", 1.0, "", "", outcome, "here")
    return Row(*asked, **{"ready_s": 0.006, "first_s": 0.01, "path_s": 0.02, **more})


def held(rows: list[Row]) -> dict[str, tuple[int, int]]:
    """Of how many each aim holds, by its first words."""
    return {" ".join(aim.sentence.split()[:4]): (aim.confirmed, aim.of) for aim in aims(rows)}


def test_the_report_counts_what_touches() -> None:
    rows = [row("a", OURS, contacts=0, **TIMED), row("a", OMPL, contacts=3), row("b", OMPL, contacts=0)]
    rows += [row("a", ROBOPLAN, contacts=0, **TIMED | {"motion_contact": "x at 1 s", "duration_s": 1.0})]
    report = to_markdown(rows)
    assert "| planner | 1 | 1 |" in report
    assert "a, OMPL RRTConnect, plain coal touches: here." in report
    assert "a, motion of roboplan touches: x at 1 s." in report
    assert "Limits: slowly." in report
    header, _, ours, ompl, roboplan = [
        [cell.strip() for cell in line.split("|")] for line in report.splitlines() if line.startswith("|")
    ]
    columns = [dict(zip(header, line, strict=True)) for line in (ours, ompl, roboplan)]
    assert [line["paths touching"] for line in columns] == ["0 of 1", "1 of 2", "0 of 1"]
    assert [line["motions touching"] for line in columns] == ["-", "-", "1 of 1"]
    assert [line["total (s)"] for line in columns] == ["0.03", "-", "0.03"]
    assert [line["98 % (s)"] for line in columns] == ["0.03", "0.02", "0.03"]  # of the path where there is no motion


def test_times_are_compared_problem_by_problem() -> None:
    ours = [
        row(name, OURS, contacts=0, **TIMED | {"total_s": total})
        for name, total in zip("abcd", (1.0, 2.0, 3.0, 9.0), strict=True)
    ]
    other = [
        row(name, ROBOPLAN, **TIMED | {"total_s": total}) for name, total in zip("abc", (4.0, 4.0, 4.0), strict=True)
    ]
    report = to_markdown([*ours, *other, row("d", ROBOPLAN, NO_PATH), row("a", OMPL, path_s=0.04)])
    assert "- From problem to motion: 0.50 of roboplan's time, in the median of 3 problems." in report
    assert (
        "- A path after shortcuts: 0.50 of OMPL RRTConnect, plain coal's time, in the median of 1 problems." in report
    )
    assert "From problem to motion: 0.50 of OMPL" not in report


def test_the_aims_are_judged_by_medians_means_and_98_percent() -> None:
    quick = [row(str(k), OURS, contacts=0, duration_s=1.2, **TIMED) for k in range(9)]
    found = held(quick)
    assert found["In the median ready"] == (1, 1)
    assert found["In the median a"] == (1, 1)  # the last of this beginning: a motion
    assert found["From problem to motion"] == (1, 1)
    assert found["It is 0.081 s"] == (1, 1)
    assert found["Motions take 1.25 s"] == (1, 1)
    assert found["They are no longer"] == (0, 0)
    assert found["With the whole roadmap,"] == (0, 0)
    slow = [row(str(k), WHOLE, contacts=1, duration_s=9.0, **TIMED | {"total_s": 0.1 + 0.3 * k}) for k in range(3)]
    found = held([*quick, *slow])
    assert found["With the whole roadmap,"] == (1, 1)  # 0.4 s, of 0.1, 0.4 and 0.7 s
    assert found["No path of ours"] == (9, 12)
    assert found["Motions take 1.25 s"] == (1, 1)  # of paths alone
    late = row("late", OURS, contacts=0, duration_s=3.0, **TIMED | {"total_s": 0.2, "largest_share": 1.1})
    beside = [row("0", ROBOPLAN, duration_s=1.1), row("elsewhere", ROBOPLAN, duration_s=9.0)]
    found = held([*quick, late, row("none", OURS, NO_PATH), *beside])
    assert found["We solve every problem."] == (10, 11)
    assert found["No motion of ours"] == (9, 10)  # the last of this beginning: limits
    assert found["From problem to motion"] == (1, 1)
    assert found["It is 0.081 s"] == (0, 1)
    assert found["Motions take 1.25 s"] == (0, 1)  # (9 · 1.2 + 3) / 10
    assert found["They are no longer"] == (0, 1)  # on the same problem 1.2 s beside 1.1 s
