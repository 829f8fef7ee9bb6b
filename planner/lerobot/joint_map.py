"""Columns of LeRobot's states and actions as joints of a robot in rad."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Floats, Ints, frozen
from planner.base.errors import OptionError, choices

UNITS = ("degrees", "normalized", "rad")
SUFFIX = ".pos"
SPANS = {"wrist_roll": (-np.pi, np.pi)}  # lerobot calibrates this joint of the SO-100 and SO-101 as a full turn


@dataclass(frozen=True, eq=False)
class JointMap:
    """For each of ``joints`` (dof,) its column among ``names`` (a,): rad = offset + scale * value.

    Columns without a joint pass through, as those of a gripper.
    """

    names: tuple[str, ...]
    joints: tuple[str, ...]
    columns: Ints
    scale: Floats
    offset: Floats

    @staticmethod
    def from_limits(
        names: Sequence[str],
        joints: Sequence[str],
        lower: Floats | Sequence[float],
        upper: Floats | Sequence[float],
        units: str = "degrees",
        spans: Mapping[str, tuple[float, float]] | None = None,
        renamed: Mapping[str, str] | None = None,
    ) -> JointMap:
        """Return the map of columns ``names``, each a joint with ".pos", or the joint that ``renamed`` names.

        ``units`` are "degrees" from the zero of the URDF, "rad", or "normalized": -100 and 100 are the ends of a span,
        by default the joint's limits ``lower``, ``upper`` (dof,) rad, and a full turn for "wrist_roll". ``spans`` gives
        other ones by joint. Raises :class:`OptionError` for a joint without a column and for unknown names.
        """
        names, joints, renamed = tuple(names), tuple(joints), renamed or {}
        owners = [renamed.get(name, name.removesuffix(SUFFIX)) for name in names]
        if units not in UNITS:
            raise OptionError(f"units must be one of {choices(UNITS)}, got {units!r}.")
        for kind, given, known in (("renamed", renamed, names), ("spans", spans or {}, joints)):
            if unknown := [name for name in given if name not in known]:
                raise OptionError(f"{kind} must name {choices(known)}, got {unknown[0]!r}.")
        if missing := [joint for joint in joints if owners.count(joint) != 1]:
            raise OptionError(
                f"names must have one column of joint '{missing[0]}', got {choices(names)}: give the names of the "
                "policy's actions in their order, and 'renamed' where they differ."
            )
        scale = np.full(len(joints), np.pi / 180.0 if units == "degrees" else 1.0)
        offset = np.zeros(len(joints))
        if units == "normalized":
            ends = dict(zip(joints, zip(lower, upper, strict=True), strict=True)) | SPANS | dict(spans or {})
            low, high = np.array([ends[joint] for joint in joints], dtype=np.float64).T
            if not (np.isfinite(high - low) & (high > low)).all():
                raise OptionError("spans must have two finite ends of each joint, the lower first: add those missing.")
            scale, offset = (high - low) / 200.0, (high + low) / 2.0
        columns = np.array([owners.index(joint) for joint in joints], dtype=np.int64)
        return JointMap(names, joints, columns, frozen(scale), frozen(offset))

    def to_joints(self, values: Floats) -> Floats:
        """Return joint values (k, dof), rad, of rows (k, a)."""
        return self.offset + self.scale * values[:, self.columns]

    def replace(self, values: Floats, positions: Floats) -> Floats:
        """Return the rows (k, a) with the columns of joints replaced by ``positions`` (k, dof), rad."""
        rows = values.copy()
        rows[:, self.columns] = (positions - self.offset) / self.scale
        return rows
