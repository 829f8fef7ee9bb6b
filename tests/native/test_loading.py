"""Compiled code that is missing is said in one sentence with its remedy."""

import importlib
import sys

import pytest

import planner.native
from planner.base.errors import InstallationError


def test_missing_compiled_code_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "planner.native.compiled", None)
    with pytest.raises(InstallationError, match="install the package again"):
        importlib.reload(planner.native)
