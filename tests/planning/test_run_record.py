"""What every written record begins with."""

import json

from planner.base.formats import FORMAT_VERSION
from planner.base.versions import versions
from planner.planning.run_record import run_record
from planner.problem.outcome import Outcome
from planner.problem.request import RoadmapRequest
from planner.robot.scene import Scene
from tests.worlds import load


def test_it_says_what_was_asked_how_it_ended_and_by_what() -> None:
    request, robot = RoadmapRequest.from_options(robot="ur5", scene="shelf", seed=7), load("ur5")
    record = run_record(request, Outcome.NO_PATH, robot, Scene.load("shelf"))
    assert json.loads(json.dumps(record)) == record
    assert record["format_version"] == FORMAT_VERSION
    assert (record["outcome"], record["message"]) == ("no_path", Outcome.NO_PATH.value)
    assert (record["robot"], record["scene"], record["seed"]) == ("ur5", "shelf", 7)
    assert record["config"] == json.loads(json.dumps(request.config()))
    assert record["versions"] == versions()
    assert (record["joints"], record["tool"]) == (list(robot.joints), robot.tool)
