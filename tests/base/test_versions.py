"""Versions of the software that results come from."""

import importlib.metadata
import platform

import numpy as np
import pytest

from planner.base.versions import DECISIVE, versions


def test_what_decides_a_plans_numbers_is_named() -> None:
    found = versions()
    assert tuple(found) == DECISIVE
    assert found["numpy"] == np.__version__
    assert found["python"] == platform.python_version()
    assert found["machine"] == platform.machine()


def test_a_package_that_is_not_there() -> None:
    with pytest.raises(importlib.metadata.PackageNotFoundError):
        versions(("no-such-package",))
