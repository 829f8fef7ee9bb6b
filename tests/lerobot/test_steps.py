"""The steps around the filter, with the few names of ``lerobot.processor`` that they use; the real one: by hand."""

import sys
from collections.abc import Iterator
from enum import StrEnum
from importlib import import_module
from types import ModuleType, SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

from planner.base.errors import OptionError, StateError
from tests.lerobot.conftest import NAMES, Make, chunk_to


class TransitionKey(StrEnum):
    OBSERVATION = "observation"
    ACTION = "action"
    INFO = "info"
    COMPLEMENTARY_DATA = "complementary_data"


class Registry:
    names: ClassVar[dict[str, type]] = {}

    @classmethod
    def register(cls, name: str) -> Any:
        return lambda step: cls.names.setdefault(name, step)


class Tensor:
    """As much of a torch tensor as the steps use."""

    def __init__(self, values: Any) -> None:
        self.values = np.asarray(values, dtype=np.float32)

    def new_tensor(self, values: Any) -> "Tensor":
        return Tensor(values)

    def detach(self) -> "Tensor":
        return self

    def cpu(self) -> "Tensor":
        return self

    def double(self) -> "Tensor":
        return self

    def numpy(self) -> np.ndarray:
        return self.values.astype(np.float64)


@pytest.fixture(scope="module")
def steps() -> Iterator[Any]:
    library = ModuleType("lerobot.processor")
    library.__dict__.update(ProcessorStep=object, ProcessorStepRegistry=Registry, TransitionKey=TransitionKey)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "lerobot", ModuleType("lerobot"))
        patch.setitem(sys.modules, "lerobot.processor", library)
        yield import_module("planner.lerobot.steps")
        patch.delitem(sys.modules, "planner.lerobot.steps")


def test_a_pair_in_a_policys_pipelines(steps: Any, make: Make) -> None:
    actions = make(unsafe="stop")
    before, after = SimpleNamespace(steps=["rename"]), SimpleNamespace(steps=["unnormalize"])
    steps.add_gate(before, after, actions)
    assert (before.steps[1:], after.steps[:-1]) == (["rename"], ["unnormalize"])
    seen = {"observation": {"observation.state": Tensor(np.zeros((1, 6)))}, "action": None}
    assert before.steps[0](seen) is seen
    safe = {"action": Tensor(chunk_to(30.0)), "info": {"other": 1}, "complementary_data": None}
    done = after.steps[-1](safe)
    assert done["action"] is safe["action"]
    assert (done["info"]["other"], done["info"]["planner_gate"]["outcome"]) == (1, "safe")
    before.steps[0](seen)
    done = after.steps[-1]({"action": Tensor(chunk_to(-80.0)), "info": {}})
    for key in ("info", "complementary_data"):
        assert done[key]["planner_gate"]["outcome"] == "cut"
        assert "wall" in done[key]["planner_gate"]["reason"]
    assert done["action"].values.shape == (1, 30, 6)
    assert done["action"].values[0, -1, 0] > -40.0
    assert done["info"]["planner_gate"]["counts"] == {"safe": 1, "cut": 1}
    after.steps[-1].reset()
    with pytest.raises(StateError, match=r"observation\.state must come before"):
        after.steps[-1](safe)


def test_one_action_with_its_observation(steps: Any, make: Make) -> None:
    step = steps.GateAction(make(unsafe="stop"))
    here = dict.fromkeys(NAMES, 0.0) | {"camera": "picture"}
    action = dict.fromkeys(NAMES, 0.0) | {"shoulder_pan.pos": 3.0, "gripper.pos": 40.0, "other": 1}
    done = step({"action": action, "observation": here, "info": {}})
    assert done["action"] == action
    far = step({"action": action | {"shoulder_pan.pos": -80.0}, "observation": here, "info": {}})
    assert far["info"]["planner_gate"]["outcome"] != "safe"
    assert far["action"]["shoulder_pan.pos"] > -10.0
    assert (far["action"]["gripper.pos"], far["action"]["other"]) == (40.0, 1)
    with pytest.raises(StateError, match=r"observation must have 'shoulder_pan\.pos', got camera"):
        step({"action": action, "observation": {"camera": 1}})


def test_a_pipeline_that_was_saved_needs_its_filter_again(steps: Any) -> None:
    assert set(Registry.names) == {"planner_gate_state", "planner_gate_chunk", "planner_gate_action"}
    step = Registry.names["planner_gate_chunk"]()
    assert step.transform_features({"action": 1}) == {"action": 1}
    step.reset()
    with pytest.raises(OptionError, match="GateChunk must have a filter, got none"):
        step({"action": Tensor(chunk_to(30.0))})
