"""Folders as 'planner plan --certificate' leaves them, of paths and motions that are made here."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from planner.base.arrays import Floats
from planner.certificate import PROOF_NAME, Certificate, make_certificate
from planner.collision.checker import CollisionChecker
from planner.problem.targets import joints_text
from planner.trajectory.file import TRAJECTORY_NAME
from planner.trajectory.trajectory import Trajectory

AROUND = np.array([[-1.0, 0.8], [-0.4, 2.2], [0.4, 2.2], [1.0, 0.4]])  # planar_2r, folded past the post


def folder_of(
    folder: Path, checker: CollisionChecker, path: Floats, motion: Trajectory | None = None, floor: float = 0.0
) -> tuple[Path, Certificate]:
    """The folder with a certificate of a path (k, dof) and perhaps a motion, as far as the checker reads it."""
    folder.mkdir(exist_ok=True)
    world = checker.world
    certificate = make_certificate(checker, path, motion, floor)
    certificate.save(folder / PROOF_NAME)
    record = {"robot": world.robot.name, "scene": world.scene.name, "joints": world.robot.joints}
    ends = [joints_text(q) for q in path[[0, -1]].tolist()]
    config = {"margin": world.margin, "start": ends[0], "goal": ends[1], "request": None, "min_manipulability": floor}
    record |= {"path": path.tolist(), "config": config, "goal": ends[1]}
    (folder / "plan.json").write_text(json.dumps(record))
    if motion is not None:
        motion.save(folder / TRAJECTORY_NAME)
    return folder, certificate
