"""``planner reproduce`` as its users type it."""

from __future__ import annotations

import sys

import pytest

from planner import cli


def test_options_of_a_robot_need_one(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["planner", "reproduce", "learning", "--scene", "paper", "--nodes", "50"])
    with pytest.raises(SystemExit) as stop:
        cli.main()
    assert stop.value.code == 2
    assert "--scene, --nodes asks for a robot's roadmaps: give --robot too" in capsys.readouterr().err
