"""The report of a check: findings with a sentence each, and the measures and proofs of a motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from planner.base.arrays import Floats
from planner.base.errors import choices
from planner.collision.checker import CollisionChecker
from planner.trajectory.limits import KINDS
from planner.trajectory.measure import CLOSE, NOTHING_NEAR, TOO_CLOSE, TOO_CLOSE_TEXT, Nearest, nearest_text

Kind = Literal["contact", "limit", "discontinuity", "floor", "constraint", "clearance"]


@dataclass(frozen=True, eq=False)
class Finding:
    """A fault of a motion: its ``kind``, its location ``where``, and its subject ``what``.

    ``where`` is a start and an end: in s on a trajectory, in segments from the start on a path (2.25 is a quarter of
    the third segment). ``what`` names a pair (contact; clearance: within the margin), a quantity and its joint (limit,
    discontinuity), or a condition (constraint, floor). ``value`` was measured, ``allowed`` is its bound, in ``unit``; a
    jump has an infinite value, which is None. ``text`` replaces the composed sentence, ``note`` follows it. ``q``
    (dof,) is the configuration.
    """

    kind: Kind
    what: tuple[str, ...]
    where: tuple[float, float]
    value: float | None = None
    allowed: float | None = None
    unit: str = "m"
    timed: bool = True
    q: Floats | None = None
    note: str = ""
    text: str = ""

    @property
    def sentence(self) -> str:
        """The finding in words, without a full stop."""
        return (self.text or f"{self._head()} {location_text(self.where, self.timed)}") + self.note

    def _head(self) -> str:
        value, allowed, pair = self.value or 0.0, self.allowed or 0.0, " and ".join(f"'{name}'" for name in self.what)
        match self.kind:
            case "contact":
                return f"{pair} touch"
            case "clearance":
                return f"{pair} are closer than the margin of {allowed:g} m"
            case "constraint":
                return f"'{self.what[0]}' is broken by {value:.3g} {self.unit}"
            case "floor":
                return f"manipulability is {value:.3g}, below the floor of {allowed:.3g}"
        quantity, joint = self.what
        if quantity == "position":
            beyond = f"{abs(value - allowed):.3g} {self.unit} beyond its limit of {allowed:.6g}"
            return f"joint '{joint}' is at {value:.6g}, {beyond},"
        over = f"{100 * (value / allowed - 1):.3g} % over its limit of {allowed:g},"
        return f"joint '{joint}' reaches {value:.6g} {self.unit} of {quantity}, {over}"

    def to_dict(self) -> dict[str, Any]:
        """Return the finding as plain data, with its sentence."""
        record = {name: getattr(self, name) for name in ("kind", "value", "allowed", "unit", "sentence")}
        q = None if self.q is None else self.q.tolist()
        return record | {"what": list(self.what), "where": list(self.where), "q": q}


def location_text(where: tuple[float, float], timed: bool) -> str:
    """Return a location on a trajectory (s) or on a path (segments) as part of a sentence."""
    begin, end = where
    if timed:
        return f"at {begin:.4f} s" if begin == end else f"between {begin:.4f} and {end:.4f} s"
    if begin == end:
        row, share = int(begin), begin % 1
        return f"in segment {row + 1} at {100 * share:.1f} %" if share else f"at waypoint {row + 1}"
    return f"in segment {int(begin) + 1}, between two samples"


@dataclass(frozen=True, eq=False)
class Report:
    """A check of a path, a trajectory (``timed``) or a task, with its segments as ``parts``.

    The ``checker`` holds robot and scene; samples are ``step`` metres of motion apart. ``pieces`` counts proofs by
    verdict. ``clearance`` is the smallest one, None if no pair is checked. ``measures`` are data by name: sizes,
    lengths, w, shares of limits, results of constraints, and limits that were not checked.
    """

    checker: CollisionChecker
    step: float
    timed: bool
    findings: tuple[Finding, ...] = ()
    pieces: dict[str, int] = field(default_factory=dict)
    clearance: Nearest | None = None
    measures: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    title: str = ""
    parts: tuple[Report, ...] = ()

    def __bool__(self) -> bool:
        return self.ok

    def __repr__(self) -> str:
        return f"<Report: {self.sentence}>"

    @property
    def ok(self) -> bool:
        """Whether the motion has no finding; unproven pieces are no finding."""
        return not self.findings

    @property
    def proven(self) -> bool:
        """Whether every piece is proven free, within limits and within all constraints."""
        if self.parts:
            return self.ok and all(part.proven for part in self.parts)
        constraints = all(each["proven"] for each in self.measures.get("constraints", ()))
        return self.ok and not self._undecided and not self.measures.get("not_judged") and constraints

    @property
    def _undecided(self) -> int:
        """The number of pieces that are not proven free of static or moving obstacles."""
        return self.measures.get("undecided", 0)

    @property
    def sentence(self) -> str:
        """The verdict on the motion, with its first finding."""
        if self.parts:
            bad = sum(not part.ok for part in self.parts)
            wrong = f"{bad} of {len(self.parts)} segments are not free and within limits, or end wrongly."
            return wrong if bad else "All segments are free."
        if self.findings:
            return f"Not usable: {self.findings[0].sentence.rstrip('.')}."
        piece = "piece between two points" if self.timed else "segment"
        limits, note = "all limits" if self.timed else "limits", ""
        if unchecked := self.measures.get("not_judged", []):
            limits = f"the limits on {' and '.join(kind for kind in ('position', *KINDS) if kind not in unchecked)}"
            jump = self.measures["jump"]
            note = f"; {' and '.join(unchecked)} not checked, as {jump} and the limit is only assumed"
        horizon = f" Obstacles with a speed limit: {self._horizon()}." if "horizon" in self.measures else ""
        if self._undecided:
            left = f"{count_text(self._undecided, piece.split()[0])} could not be proven"
            return f"Free and within {limits} at every sample; {left}{note}.{horizon}"
        return f"Free and within {limits}; every {piece} is proven free as a whole{note}.{horizon}"

    def rows(self) -> list[tuple[str, str]]:
        """Return the report as rows of a table."""
        if self.parts:
            return [(part.title, part._line()) for part in self.parts]
        m, findings = self.measures, [(each.kind, each.sentence) for each in self.findings]
        rows = [("trajectory" if self.timed else "path", self._size())]
        rows += [("limits", m["limits"]["text"])] if self.timed else []
        rows += [*(("note", note) for note in self.notes), *findings]
        if "w_min" not in m:
            return rows
        shares = [(kind, share) for kind, share in m.get("shares", {}).items() if share is not None]
        rows += [(kind, f"{100 * share:.1f} % of the limit at most") for kind, share in shares]
        open_text = f"infinite, as {m.get('jump')}; not checked, as the limit is only assumed"
        rows += [(kind, open_text) for kind in m.get("not_judged", [])]
        if not {"contact", "clearance"} & {kind for kind, _ in findings}:
            rows.append(("contacts", f"none, sampled every {1000 * self.step:g} mm of motion"))
        rows.append(("smallest clearance", self._clearance()))
        if self.ok and self.clearance and self.clearance.min < CLOSE:
            rows.append((TOO_CLOSE, TOO_CLOSE_TEXT))
        rows.append(("proofs", self._proofs()))
        if "moving" in m:
            clear, of = m["moving"]["pieces_free"], count_text(sum(self.pieces.values()), "piece")
            rows.append(("known motions", f"{clear} of {of} proven clear of {choices(m['moving']['obstacles'])}"))
        rows += [("horizon", self._horizon())] if "horizon" in m else []
        least = f"min {m['w_min']:.3g} ({self._at(m['w_at'])}), mean {m['w_mean']:.3g}"
        rows.append(("manipulability w", f"{least}, frame {self.checker.robot.tool_text}"))
        for each in m["constraints"]:
            proof = "proven on the whole motion" if each["proven"] else "NOT proven between samples"
            slack = f"'{each['condition']}' with a slack of {each['spare']:.3g} {each['unit']}"
            rows += [] if each["strays"] else [("constraint", f"{slack} {self._at(each['at'])}, {proof}")]
        return rows

    def _size(self) -> str:
        m = self.measures
        size = count_text(m["points"], "point" if self.timed else "waypoint")
        if "duration" in m:
            late = f", from {m['begin']:.3f} s on" if m["begin"] > 0 else ""
            return f"{size}, {m['duration']:.3f} s{late}, with {m['interpolation']} between them"
        return f"{size}, {m['joint_length']:.3f} rad, {m['workspace_length']:.3f} m" if "w_min" in m else size

    def _clearance(self) -> str:
        if self.clearance is None:
            return NOTHING_NEAR
        at = self._at(self.clearance.at)
        return f"none {at}" if self.clearance.min <= 0.0 and not self.ok else f"{nearest_text(self.clearance)} {at}"

    def _proofs(self) -> str:
        piece = count_text(sum(self.pieces.values()), "piece" if self.timed else "segment")
        text, bound = f"{self.pieces['free']} of {piece} proven free as a whole", self.measures.get("proven_distance")
        return f"{text}, to keep {1000 * bound:.2f} mm from everything" if bound else text

    def _at(self, place: float) -> str:
        return location_text((place, place), self.timed)

    def _horizon(self) -> str:
        """Return the time until which unknown motions cannot touch the robot, as part of a sentence."""
        until, limits = (self.measures["horizon"][name] for name in ("free_until", "speed_limits"))
        speeds = choices(f"{name} below {limit:g} m/s" for name, limit in limits.items())
        return f"no contact {'at any time' if until is None else f'before {until:.3f} s'} with any motion of {speeds}"

    def _line(self) -> str:
        """Return the row of a segment of a task."""
        allowed = "".join(f"; '{a}' may touch '{b}'" for a, b in self.measures["may_touch"])
        return ("; ".join(each.sentence.rstrip(".") for each in self.findings) or "free") + allowed

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain data: s, rad and m; locations on a path in segments from 0."""
        world = self.checker.world
        record = {"ok": self.ok, "message": self.sentence, "robot": world.robot.name, "scene": world.scene.name}
        record |= {"joints": list(world.robot.joints), "frame": world.robot.tool_text, "collision": self.checker.name}
        record |= {"margin": world.margin, "step": self.step, "proven": self.proven, "notes": list(self.notes)}
        if self.parts:
            return record | {"segments": [{"title": part.title, **part.to_dict()} for part in self.parts]}
        findings = [each.to_dict() for each in self.findings]
        clearance = None if self.clearance is None else self.clearance.to_dict()
        return record | {"findings": findings, "pieces": self.pieces, "clearance": clearance} | self.measures


def count_text(number: int, thing: str) -> str:
    """Return "1 edge", "2 edges"."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def floor_text(floor: dict[str, Any]) -> str:
    """Return the content of a trajectory's ``proof.floor`` as part of a sentence."""
    above, exempt, below = (floor[f"pieces_{name}"] for name in ("above", "exempt", "below"))
    pieces, bound = count_text(above + exempt + below, "piece"), f"the floor of {floor['asked']:g}"
    if below:
        return f"w is NOT proven above {bound} in {below} of {pieces}"
    if not above:
        return f"w is proven nowhere: it stays above {bound} on none of {pieces}"
    rest = f"; the other {exempt} lead up from the start or down to the goal" if exempt else ""
    return f"w is proven above {bound} in {above} of {pieces}{rest}"
