"""``planner task`` as a user types it, and ``planner check`` and ``export`` of its files."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from planner.base.resources import data_folder
from tests.command_line import Run, assert_total_covers

EXAMPLES = data_folder("scenes") / "examples"
SCENE = str(EXAMPLES / "two-boards.yaml")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("task")


@pytest.fixture
def tidy(folder: Path, run: Run) -> Path:
    """The example, planned once."""
    out = folder / "tidy"
    if not out.exists():
        code, text, error = run("task", str(EXAMPLES / "tidy.yaml"), "--nodes", "60", "--out", str(out))
        assert code == 0, error
        assert "step 2, place mug: transit, holding mug" in text
        assert "all proven" in text
    return out


def test_it_writes_segments_and_events(tidy: Path) -> None:
    assert {path.name for path in tidy.iterdir()} == {"plan.json", "plan.html", "roadmap.npz", "trajectory.json"}
    record = json.loads((tidy / "plan.json").read_text())
    assert record["outcome"] == "solved"
    assert [segment["carried"] for segment in record["segments"]] == [None, None, *["mug"] * 3, None, None]
    assert set(record["segments"][0]) >= {"step", "carried", "path", "trajectory"}
    assert [event["kind"] for event in record["events"]] == ["gripper", "attach", "detach", "gripper"]
    assert record["gabf"]["max_error_vs_oracle"] == 0.0
    assert record["cost"]["total"] > 0
    assert_total_covers(record["timings_s"], set(record["timings_s"]) - {"total"})
    assert {"import", "files", "record", "page"} <= set(record["timings_s"])


@pytest.mark.parametrize("name", ["", "trajectory.json"])
def test_it_is_checked_whole(tidy: Path, run: Run, name: str) -> None:
    """By the robot and the scene of its plan.json."""
    code, text, error = run("check", str(tidy / name))
    assert code == 0, error
    assert text.rstrip().endswith("All segments are free.")


def without(kind: str) -> Callable[[dict], None]:
    def damage(plan: dict) -> None:
        plan["events"] = [event for event in plan["events"] if event["kind"] != kind]

    return damage


def shifted(plan: dict, number: int, row: int, by: float) -> None:
    plan["segments"][number]["path"][row][1] += by


DAMAGES: dict[str, tuple[Callable[[dict, dict], object], int]] = {  # of a plan and its motion
    "no attach": (lambda plan, _: without("attach")(plan), 3),
    "a waypoint in contact": (lambda plan, _: shifted(plan, 3, 1, 1.2), 4),
    "an end elsewhere": (lambda plan, _: shifted(plan, 0, -1, 0.01), 3),
    "a segment lacks": (lambda plan, _: plan["segments"].pop(3), 3),
    "another is held": (lambda plan, _: plan["segments"][3].update(carried=None), 3),
    "a failure": (lambda plan, _: plan.update(outcome="no_path"), 3),
    "a swing while the gripper closes": (lambda _, motion: swing(motion, motion["events"][0]["t"]), 3),
    "faster than the arm": (lambda _, motion: motion["limits"].update(velocity=[99.0] * 7), 3),
    "another motion": (lambda _, motion: motion["points"][len(motion["points"]) // 2].update(q=[0.3] * 7), 4),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_a_damaged_plan_or_motion_is_refused(tidy: Path, run: Run, tmp_path: Path, name: str) -> None:
    damage, code = DAMAGES[name]
    plan, motion = (json.loads((tidy / file).read_text()) for file in ("plan.json", "trajectory.json"))
    damage(plan, motion)
    for file, record in (("plan.json", plan), ("trajectory.json", motion)):
        (tmp_path / file).write_text(json.dumps(record))
    assert run("check", str(tmp_path))[0] == code


def swing(motion: dict, after: float) -> None:
    """The motion goes elsewhere where no segment runs."""
    row = max(k for k, point in enumerate(motion["points"]) if point["t"] <= after)
    there = motion["points"][row]
    motion["points"].insert(row + 1, {**there, "t": there["t"] + 0.1, "q": [*there["q"][:6], there["q"][6] + 0.5]})


def test_the_whole_motion_is_exported(tidy: Path, run: Run) -> None:
    code, _, error = run("export", str(tidy), "--format", "csv")
    assert code == 0, error
    rows = (tidy / "trajectory-csv.csv").read_text().splitlines()
    times = [float(row.split(",")[0]) for row in rows[1:]]
    assert times == sorted(set(times))


def test_an_impossible_task_ends_with_code_4(run: Run, tmp_path: Path) -> None:
    far = Path(SCENE).read_text().replace("[0.5, -0.3, 0.05]", "[1.5, -0.3, 0.05]")
    (tmp_path / "two-boards.yaml").write_text(far)
    (tmp_path / "far.yaml").write_text((EXAMPLES / "tidy.yaml").read_text())
    code, text, _ = run("task", str(tmp_path / "far.yaml"), "--out", str(tmp_path / "out"))
    assert code == 4
    reason = json.loads((tmp_path / "out/plan.json").read_text())["reason"]
    assert (reason["kind"], reason["step"], reason["what"]) == ("step_fails", 1, "no_grasp")
    assert reason["out_of_reach"] == reason["tried"] == 200
    assert "no grasp is feasible, 200 of 200 out of reach" in " ".join(text.split())
