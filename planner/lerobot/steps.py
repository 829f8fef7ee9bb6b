"""LeRobot's processor steps around an :class:`ActionFilter`: the module that imports lerobot."""
# pyright: reportMissingImports=false

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from lerobot.processor import ProcessorStep, ProcessorStepRegistry, TransitionKey

from planner.base.errors import OptionError, StateError
from planner.lerobot.action_filter import ActionFilter, Filtered

STATE = "observation.state"
KEY = "planner_gate"  # of a transition's info and complementary data


@dataclass
class _Step(ProcessorStep):
    """A step with its ``filter``, which a saved pipeline lacks: give it as an override when loading."""

    filter: ActionFilter | None = None

    @property
    def _filter(self) -> ActionFilter:
        if self.filter is None:
            raise OptionError(
                f"{type(self).__name__} must have a filter, got none: give it when the pipeline is loaded."
            )
        return self.filter

    def _with_verdict(self, transition: Any, action: Any, found: Filtered) -> Any:
        """Return the transition with the action, and verdict and counts in info and complementary data."""
        verdict = found.to_dict() | {"counts": dict(self._filter.counts)}
        new = {**transition, TransitionKey.ACTION: action}
        for key in (TransitionKey.INFO, TransitionKey.COMPLEMENTARY_DATA):
            new[key] = {**(transition.get(key) or {}), KEY: verdict}
        return new

    def reset(self) -> None:
        """Forget the episode."""
        if self.filter is not None:
            self.filter.reset()

    def transform_features(self, features: Any) -> Any:
        """Return the features unchanged."""
        return features


@ProcessorStepRegistry.register("planner_gate_state")
@dataclass
class GateState(_Step):
    """Remembers ``observation.state`` in the preprocessor, before it is normalized."""

    def __call__(self, transition: Any) -> Any:
        """Return the transition unchanged."""
        state = (transition.get(TransitionKey.OBSERVATION) or {}).get(STATE)
        if state is not None:
            self._filter.observe(_array(state))
        return transition


@ProcessorStepRegistry.register("planner_gate_chunk")
@dataclass
class GateChunk(_Step):
    """Judges actions (1, T, A) or (1, A) at the end of the postprocessor, in the units of the robot."""

    def __call__(self, transition: Any) -> Any:
        """Return the transition with safe actions and the verdict."""
        action = transition[TransitionKey.ACTION]
        found = self._filter.judge(_array(action))
        safe = action if found.outcome == "safe" else action.new_tensor(found.actions)
        return self._with_verdict(transition, safe, found)


@ProcessorStepRegistry.register("planner_gate_action")
@dataclass
class GateAction(_Step):
    """Judges one action with its observation in ``robot_action_processor``, both by names as "x.pos"."""

    def __call__(self, transition: Any) -> Any:
        """Return the transition with a safe action and the verdict."""
        names, action = self._filter.joint_map.names, transition[TransitionKey.ACTION]
        observation = transition.get(TransitionKey.OBSERVATION) or {}
        for what, given in (("action", action), ("observation", observation)):
            if missing := [name for name in names if name not in given]:
                raise StateError(
                    f"{what} must have '{missing[0]}', got {', '.join(map(str, given))[:200]}: mend 'names'."
                )
        self._filter.observe([float(observation[name]) for name in names])
        found = self._filter.judge([[float(action[name]) for name in names]])
        new = {} if found.outcome == "safe" else dict(zip(names, found.actions[0].tolist(), strict=True))
        return self._with_verdict(transition, {**action, **new}, found)


def add_gate(preprocessor: Any, postprocessor: Any, actions: ActionFilter) -> None:
    """Put :class:`GateState` first into a preprocessor and :class:`GateChunk` last into a postprocessor."""
    preprocessor.steps = [GateState(actions), *preprocessor.steps]
    postprocessor.steps = [*postprocessor.steps, GateChunk(actions)]


def _array(values: Any) -> Any:
    """Return a tensor, on any device and with any type of floats, as an array."""
    return values.detach().cpu().double().numpy() if hasattr(values, "detach") else np.asarray(values)
