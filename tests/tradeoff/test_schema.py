"""``sweep.json`` is as its schema says."""

from __future__ import annotations

import jsonschema
import pytest

from planner.problem.request import SweepRequest
from planner.tradeoff.record import sweep_record
from planner.tradeoff.sweep import sweep
from tests.planning.records import SMALL, as_written, spoilt


@pytest.mark.parametrize("validator", ["sweep"], indirect=True)
def test_sweeps_are_as_the_schema_says(validator: jsonschema.Draft202012Validator) -> None:
    record = as_written(sweep_record(sweep(SweepRequest.from_options(**SMALL))))
    validator.validate(record)
    assert not any(validator.is_valid(each) for each in spoilt(record))
