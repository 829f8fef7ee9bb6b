"""What several tests of roadmaps grow in."""

from __future__ import annotations

import pytest

from planner.collision.checker import CollisionChecker
from tests.worlds import make_post


@pytest.fixture(scope="session")
def post() -> CollisionChecker:
    return make_post()
