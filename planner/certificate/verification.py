"""``planner verify``: the checker of one file, and what it cannot know: that the world is the one of the plan."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np

from planner.base.errors import FileError
from planner.base.yamlfile import shown
from planner.certificate import verify_proof as checker
from planner.certificate.certificate import PROOF_NAME
from planner.certificate.geometry import geometry_of, words_of
from planner.collision.world import World


def verify(folder: Path, world: World) -> str:
    """What is proven of the plan in a ``folder``, made in ``world``, as sentences.

    :class:`planner.certificate.verify_proof.Refused` where something is not, :class:`FileError` without a certificate.
    """
    require_certificate(folder)
    require_same_world(folder / PROOF_NAME, world)
    source = world.robot.source.path
    said = checker.check(folder, source if source.suffix == ".urdf" else None)
    config = json.loads((folder / "plan.json").read_bytes())["config"]
    named = f"robot {shown(config.get('robot'))}, scene {shown(config.get('scene'))}"
    return f"{said}\nRobot, scene and the pairs left out are, number by number, those that plan.json names: {named}."


def require_certificate(folder: Path) -> None:
    """Raise :class:`FileError` where the folder holds none."""
    if not os.path.isfile(folder / PROOF_NAME):
        raise FileError(f"{folder / PROOF_NAME} not found: plan with --certificate, which writes it.")
    try:
        checker.read(folder / PROOF_NAME)
    except FileError:
        raise
    except checker.Refused:  # it is one, and what it says is for the checker to judge
        pass
    except Exception as error:  # as the checker has it
        reason = f"{type(error).__name__}: {error}"
        raise FileError(f"{folder / PROOF_NAME} is damaged ({reason[:200]}): plan with --certificate again.") from None


def require_same_world(proof: Path, world: World) -> None:
    """The certificate speaks of these joints, shapes and pairs to the last bit; else it is refused."""
    data, words = checker.read(proof)
    cuts = words.get("cuts")
    named = isinstance(cuts, dict) and all(isinstance(count, int) and 0 < count <= 1000 for count in cuts.values())
    checker.require(named, f"{proof} does not say how shapes are cut.")
    for name, said in words_of(world, words["cuts"]).items():
        checker.require(words.get(name) == said, f"{proof} says another {name} than what plan.json names.")
    expected = geometry_of(world, words["cuts"])
    proven = expected["left"] == checker.PROVEN  # those that could not be are open: the checker names one
    if data["left"].shape == proven.shape:
        expected["left"] = np.where(proven & (data["left"] == checker.OPEN), checker.OPEN, expected["left"])
    for name, array in expected.items():
        checker.require(np.array_equal(data[name], array), f"{proof} has other {name} than what plan.json names.")
    fastest = np.where(world.robot.velocity > 0, world.robot.velocity, np.inf) * (1.0 + checker.LIMIT)
    checker.require(data["limits"][:1] <= fastest, f"{proof} has a velocity limit beyond the robot's.")
