"""The settings of growth stand apart from what grows."""

from __future__ import annotations

import subprocess
import sys


def test_a_kept_roadmap_is_asked_without_loading_what_grows_one() -> None:
    code = (
        "import planner.roadmap.connect_endpoints, planner.roadmap.growth_settings as s, sys\n"
        "assert s.GrowthSettings() == s.GrowthSettings(range=0.8, floor=0.0)\n"
        "print({'ompl', 'planner.roadmap.grow', 'planner.roadmap.build'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
