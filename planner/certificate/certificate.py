"""A plan's certificate: made from a world, a path and perhaps a motion, written as ``proof.npz``, and verified."""

import io
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from planner.base.arrays import Floats
from planner.base.errors import FileError
from planner.base.files import StrPath, write_whole
from planner.base.yamlfile import quote
from planner.certificate import verify_proof as checker
from planner.certificate.geometry import Arrays, Cuts, describe_world, extract_geometry, find_concave, moving_pairs
from planner.certificate.witnesses import Search
from planner.collision.checker import CollisionChecker
from planner.collision.world import World
from planner.kinematics.forward import Chain
from planner.trajectory.trajectory import Trajectory

PROOF_NAME = "proof.npz"
_SLABS = (8, 32)  # into which meshes with dents are cut


@dataclass(frozen=True, eq=False)
class Certificate:
    """The ``arrays`` of a proof.npz, as :data:`planner.certificate.verify_proof.FIELDS` names them, and its ``words``.

    ``open_pairs`` are the names of pairs that are checked and that no plane between their hulls proves apart: where
    there are some it is not whole, and no checker accepts it.
    """

    arrays: Arrays
    meta: dict[str, Any]
    open_pairs: tuple[tuple[str, str], ...]

    def __repr__(self) -> str:
        return f"<Certificate: {'whole' if self.whole else f'{len(self.open_pairs)} pairs open'}>"

    @property
    def whole(self) -> bool:
        """Some pair is checked, and every one that is is proven apart on all of the path and the motion."""
        return not self.open_pairs and bool((self.arrays["left"] == checker.PROVEN).any())

    def content(self) -> bytes:
        """The file as bytes: the same for the same plan."""
        file = io.BytesIO()
        meta = np.frombuffer(json.dumps(self.meta, sort_keys=True).encode(), dtype=np.uint8)
        np.savez_compressed(file, allow_pickle=False, meta=meta, **self.arrays)
        return file.getvalue()

    def save(self, path: StrPath) -> None:
        """Write it whole or not at all; :class:`FileError` where that cannot be done."""
        write_whole(Path(path), self.content())


def make_certificate(
    checker_: CollisionChecker, path: Floats, motion: Trajectory | None = None, floor: float = 0.0
) -> Certificate:
    """Witnesses that no checked pair comes as near as the margin on any segment of a ``path`` (k, dof) or a ``motion``.

    And that w keeps to ``floor``, wherever that can be shown. The motion has to have the ends of the path. Obstacles
    that move by themselves are no part of it. Meshes with dents are cut into slabs where their hulls are too close, and
    into more where that is not enough.
    """
    world, curves, cuts = checker_.world, _curves(path, motion), dict[str, int]()
    found = _certificate(world, curves, cuts, floor)
    for slabs in _SLABS:
        close = {name.partition(", slab ")[0] for pair in found.open_pairs for name in pair}
        cuts |= dict.fromkeys(find_concave(world, close), slabs)
        found = _certificate(world, curves, cuts, floor) if cuts and not found.whole else found
    return found


def _certificate(world: World, curves: Arrays, cuts: Cuts, floor: float) -> Certificate:
    words = describe_world(world, cuts)
    arrays: Arrays = extract_geometry(world, cuts) | curves | {"floor": floor}
    rows, proven = checker.ROWS[words["rows"]], arrays["left"] == checker.PROVEN
    pairs = moving_pairs(arrays["joint"])[proven]
    witnesses, lost = Search(Chain.from_arm(world.robot), arrays, pairs, checker.curves(arrays), rows).run()
    arrays["left"][proven] = np.where(lost, checker.OPEN, checker.PROVEN)
    opened = tuple((words["items"][a], words["items"][b]) for a, b in pairs[lost].tolist())
    return Certificate(_as_written(arrays | witnesses), words, opened)


def make_motion_certificate(checker_: CollisionChecker, motion: Trajectory) -> Certificate:
    """The same of a ``motion`` alone, with the straight path through its knots."""
    return make_certificate(checker_, motion.knots(), motion)


def _curves(path: Floats, motion: Trajectory | None) -> Arrays:
    dof = path.shape[1]
    if motion is None:
        none = {"clock": np.zeros(0, dtype=np.int64), "knots": np.zeros((0, 0, dof)), "limits": np.zeros((0, dof))}
        return {"path": path, **none}
    assert motion.limits is not None
    limits = motion.limits.rows
    return {"path": path, "clock": motion.nanoseconds, "knots": np.array(motion.columns), "limits": limits}


def _as_written(arrays: Arrays) -> Arrays:
    """The arrays as the file holds them."""
    return {
        name: np.asarray(arrays[name], dtype=f"<{kind}", order="C")
        for name, (kind, *_) in checker.FIELDS.items()
        if name != "meta"
    }


def verify(folder: Path, world: World) -> str:
    """What is proven of the plan in a ``folder``, made in ``world``, as sentences.

    :class:`planner.certificate.verify_proof.Refused` where something is not, :class:`FileError` without a certificate.
    """
    require_certificate(folder)
    require_same_world(folder / PROOF_NAME, world)
    source = world.robot.source.path
    said = checker.check(folder, source if source.suffix == ".urdf" else None)
    config = json.loads((folder / "plan.json").read_bytes())["config"]
    named = f"robot {quote(config.get('robot'))}, scene {quote(config.get('scene'))}"
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
    for name, said in describe_world(world, words["cuts"]).items():
        checker.require(words.get(name) == said, f"{proof} says another {name} than what plan.json names.")
    expected = extract_geometry(world, words["cuts"])
    proven = expected["left"] == checker.PROVEN  # those that could not be are open: the checker names one
    if data["left"].shape == proven.shape:
        expected["left"] = np.where(proven & (data["left"] == checker.OPEN), checker.OPEN, expected["left"])
    for name, array in expected.items():
        checker.require(np.array_equal(data[name], array), f"{proof} has other {name} than what plan.json names.")
    fastest = np.where(world.robot.velocity > 0, world.robot.velocity, np.inf) * (1.0 + checker.LIMIT)
    checker.require(data["limits"][:1] <= fastest, f"{proof} has a velocity limit beyond the robot's.")
