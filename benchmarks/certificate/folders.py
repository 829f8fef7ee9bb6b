"""Folders as 'planner plan --certificate' leaves them, of paths and motions that are made here."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from planner.base.arrays import Floats
from planner.certificate import PROOF_NAME, Certificate, certificate_of
from planner.collision.checker import CollisionChecker
from planner.trajectory.file import TRAJECTORY_NAME, save_trajectory
from planner.trajectory.trajectory import Trajectory

AROUND = np.array([[-1.0, 0.8], [-0.4, 2.2], [0.4, 2.2], [1.0, 0.4]])  # planar_2r, folded past the post


def folder_of(
    folder: Path, checker: CollisionChecker, path: Floats, motion: Trajectory | None = None
) -> tuple[Path, Certificate]:
    """The folder with a certificate of a path (k, dof) and perhaps a motion, as far as the checker reads it."""
    folder.mkdir(exist_ok=True)
    world = checker.world
    certificate = certificate_of(checker, path, motion)
    certificate.save(folder / PROOF_NAME)
    record = {"robot": world.robot.name, "scene": world.scene.name, "joints": world.robot.joints}
    record |= {"path": path.tolist(), "config": {"margin": world.margin}}
    (folder / "plan.json").write_text(json.dumps(record))
    if motion is not None:
        save_trajectory(motion, folder / TRAJECTORY_NAME)
    return folder, certificate
