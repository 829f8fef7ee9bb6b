"""Learning on a robot's roadmaps."""

from __future__ import annotations

from typing import Any

import pytest

from planner.base.errors import OptionError
from planner.reproduce.learning.robot import RobotSettings


@pytest.mark.parametrize("bad", [{"roadmaps": 0}, {"executions": 0}, {"nodes": 5}])
def test_robot_settings_out_of_range_are_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(OptionError, match=next(iter(bad))):
        RobotSettings("iiwa14", **bad)
