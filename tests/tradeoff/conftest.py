"""A small sweep with several intervals, made once for the tests of its results and of its files."""

import pytest

from planner.problem.request import PlanRequest, SweepRequest
from planner.roadmap.storage import save_roadmap
from planner.tradeoff.result import Tradeoff
from planner.tradeoff.sweep import sweep

POST = """
obstacles: [{name: post, type: box, size: [0.1, 0.02, 0.2], position: [0.75, 0, 0]}]
states: {planar_2r: {start: "q:-1.0,0.8", goal: "q:1.0,-0.8"}}
"""


@pytest.fixture(scope="session")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Tradeoff:
    """planar_2r round a post, on 150 nodes: several intervals, and paths between them that no beta reaches."""
    scene = tmp_path_factory.mktemp("post") / "post.yaml"
    scene.write_text(POST)
    return sweep(
        request=SweepRequest.from_options(
            robot="planar_2r", scene=str(scene), nodes=150, seed=2, refinement_rounds=0, extra_clearance=0
        )
    )


@pytest.fixture(scope="session")
def again(swept: Tradeoff, tmp_path_factory: pytest.TempPathFactory) -> SweepRequest | PlanRequest:
    """The same request on its roadmap as a file, so that nothing is grown."""
    path = tmp_path_factory.mktemp("roadmap") / "roadmap.npz"
    save_roadmap(swept.roadmap, path)
    return swept.request.with_options(roadmap=path)
