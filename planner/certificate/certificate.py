"""A plan's certificate: made from a world, a path and a motion, saved as ``proof.npz``, verified."""

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
_SLABS = (8, 32)  # numbers of slabs into which concave meshes are cut


@dataclass(frozen=True, eq=False)
class Certificate:
    """The ``arrays`` of a proof.npz, :data:`planner.certificate.verify_proof.FIELDS`, and its ``meta``.

    ``open_pairs`` are the names of checked pairs that no plane between their hulls separates: with any, the certificate
    is not complete, and no checker accepts it.
    """

    arrays: Arrays
    meta: dict[str, Any]
    open_pairs: tuple[tuple[str, str], ...]

    def __repr__(self) -> str:
        return f"<Certificate: {'complete' if self.is_complete else f'{len(self.open_pairs)} pairs open'}>"

    @property
    def is_complete(self) -> bool:
        """Whether some pair is checked, and each one is proven apart on the is_complete path and motion."""
        return not self.open_pairs and bool((self.arrays["left"] == checker.PROVEN).any())

    def content(self) -> bytes:
        """Return the file as bytes: the same for the same plan."""
        file = io.BytesIO()
        meta = np.frombuffer(json.dumps(self.meta, sort_keys=True).encode(), dtype=np.uint8)
        np.savez_compressed(file, allow_pickle=False, meta=meta, **self.arrays)
        return file.getvalue()

    def save(self, path: StrPath) -> None:
        """Write the file completely or not at all; :class:`FileError` on failure."""
        write_whole(Path(path), self.content())


def make_certificate(
    checker_: CollisionChecker, path: Floats, motion: Trajectory | None = None, floor: float = 0.0
) -> Certificate:
    """Return witnesses that no checked pair comes nearer than the margin on a path (k, dof) or motion.

    And that w exceeds ``floor``, wherever that can be shown, of a robot with one tool. The motion must have the ends of
    the path. Obstacles that move by themselves are left out. Concave meshes are cut into slabs where their hulls are
    too close, and into more where that is not enough.
    """
    world, curves, cuts = checker_.world, _curves(path, motion), dict[str, int]()
    floor = 0.0 if world.robot.other_tools else floor
    certificate = _certify(world, curves, cuts, floor)
    for slabs in _SLABS:
        close = {name.partition(", slab ")[0] for pair in certificate.open_pairs for name in pair}
        cuts |= dict.fromkeys(find_concave(world, close), slabs)
        if cuts and not certificate.is_complete:
            certificate = _certify(world, curves, cuts, floor)
    return certificate


def _certify(world: World, curves: Arrays, cuts: Cuts, floor: float) -> Certificate:
    words = describe_world(world, cuts)
    arrays: Arrays = extract_geometry(world, cuts) | curves | {"floor": floor}
    rows, proven = checker.ROWS[words["rows"]], arrays["left"] == checker.PROVEN
    pairs = moving_pairs(arrays["joint"])[proven]
    witnesses, lost = Search(Chain.from_arm(world.robot), arrays, pairs, checker.curves(arrays), rows).run()
    arrays["left"][proven] = np.where(lost, checker.OPEN, checker.PROVEN)
    open_pairs = tuple((words["items"][a], words["items"][b]) for a, b in pairs[lost].tolist())
    return Certificate(_cast(arrays | witnesses), words, open_pairs)


def make_motion_certificate(checker_: CollisionChecker, motion: Trajectory) -> Certificate:
    """Return the certificate of a ``motion`` alone, with the straight path through its knots."""
    return make_certificate(checker_, motion.knots(), motion)


def _curves(path: Floats, motion: Trajectory | None) -> Arrays:
    dof = path.shape[1]
    if motion is None:
        none = {"clock": np.zeros(0, dtype=np.int64), "knots": np.zeros((0, 0, dof)), "limits": np.zeros((0, dof))}
        return {"path": path, **none}
    assert motion.limits is not None
    limits = motion.limits.rows
    return {"path": path, "clock": motion.nanoseconds, "knots": np.array(motion.columns), "limits": limits}


def _cast(arrays: Arrays) -> Arrays:
    """Return the arrays with the types of the file."""
    return {
        name: np.asarray(arrays[name], dtype=f"<{kind}", order="C")
        for name, (kind, *_) in checker.FIELDS.items()
        if name != "meta"
    }


def verify(folder: Path, world: World) -> str:
    """Return the proven statements about the plan in a ``folder``, made in ``world``, as sentences.

    :class:`planner.certificate.verify_proof.Refused` where something is not proven, :class:`FileError` without a
    certificate.
    """
    require_certificate(folder)
    require_same_world(folder / PROOF_NAME, world)
    source = world.robot.source.path
    verdict = checker.check(folder, source if source.suffix == ".urdf" else None)
    config = json.loads((folder / "plan.json").read_bytes())["config"]
    named = f"robot {quote(config.get('robot'))}, scene {quote(config.get('scene'))}"
    named = f"cell {quote(config['cell'])}" if config.get("cell") else named
    return f"{verdict}\nRobot, scene and the pairs left out equal, number by number, those of plan.json: {named}."


def require_certificate(folder: Path) -> None:
    """Raise :class:`FileError` unless the folder has a certificate."""
    if not os.path.isfile(folder / PROOF_NAME):
        raise FileError(f"{folder / PROOF_NAME} not found: plan with --certificate to write it.")
    try:
        checker.read(folder / PROOF_NAME)
    except FileError:
        raise
    except checker.Refused:  # verify reports it
        pass
    except Exception as error:  # any error of a damaged file, as in checker.check
        reason = f"{type(error).__name__}: {error}"
        raise FileError(f"{folder / PROOF_NAME} is damaged ({reason[:200]}): plan with --certificate again.") from None


def require_same_world(proof: Path, world: World) -> None:
    """Refuse a certificate whose joints, shapes and pairs differ from ``world`` in any bit."""
    data, words = checker.read(proof)
    cuts = words.get("cuts")
    named = isinstance(cuts, dict) and all(isinstance(count, int) and 0 < count <= 1000 for count in cuts.values())
    checker.require(named, f"{proof} does not give the cuts of shapes.")
    for name, value in describe_world(world, words["cuts"]).items():
        checker.require(words.get(name) == value, f"{proof} has another {name} than plan.json.")
    expected = extract_geometry(world, words["cuts"])
    proven = expected["left"] == checker.PROVEN  # unproven ones are open: the checker names one
    if data["left"].shape == proven.shape:
        expected["left"] = np.where(proven & (data["left"] == checker.OPEN), checker.OPEN, expected["left"])
    for name, array in expected.items():
        checker.require(np.array_equal(data[name], array), f"{proof} has another {name} than plan.json.")
    fastest = np.where(world.robot.velocity > 0, world.robot.velocity, np.inf) * (1.0 + checker.LIMIT)
    checker.require(data["limits"][:1] <= fastest, f"{proof} has a velocity limit beyond the robot's.")
