"""What a sweep writes, and what it goes on from."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from planner.base.errors import FileError
from planner.base.formats import FORMAT_VERSION
from planner.base.request import SweepRequest
from planner.tradeoff.record import read_checkpoint, save_sweep
from planner.tradeoff.sweep import sweep
from tests.schemas.test_schemas import SMALL


def test_a_sweep_of_a_newer_planner_is_not_gone_on_from(tmp_path: Path) -> None:
    request = SweepRequest(**SMALL)
    record = save_sweep(sweep(request), tmp_path)
    read_checkpoint(request, tmp_path)
    (tmp_path / "sweep.json").write_text(json.dumps({**record, "format_version": FORMAT_VERSION + 1}))
    with pytest.raises(FileError, match="update the planner"):
        read_checkpoint(request, tmp_path)
