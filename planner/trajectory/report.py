"""The report of a check: findings as data with a sentence each, and what was measured and proven of the motion."""

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
    """A fault of a motion: its ``kind``, ``where`` it begins and ends, and ``what`` is at fault.

    ``where`` is in s on a trajectory. On a path it is in segments from the start: 2.25 is a quarter of the third one.
    ``what`` names two things (contact, and clearance: closer than the margin), a quantity and its joint (limit,
    discontinuity), or a condition (constraint, floor). ``value`` stands for what is, ``allowed`` for what may be, in
    ``unit``; a jump makes it infinite, which is None. ``text`` replaces the composed sentence, ``note`` follows it.
    ``q`` (dof,) is the configuration.
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
        """As plain data, with the sentence."""
        found = {name: getattr(self, name) for name in ("kind", "value", "allowed", "unit", "sentence")}
        q = None if self.q is None else self.q.tolist()
        return found | {"what": list(self.what), "where": list(self.where), "q": q}


def location_text(where: tuple[float, float], timed: bool) -> str:
    """Where something is on a trajectory (s) or on a path (segments), as part of a sentence."""
    begin, end = where
    if timed:
        return f"at {begin:.4f} s" if begin == end else f"between {begin:.4f} and {end:.4f} s"
    if begin == end:
        whole, share = int(begin), begin % 1
        return f"in segment {whole + 1} at {100 * share:.1f} %" if share else f"at waypoint {whole + 1}"
    return f"in segment {int(begin) + 1}, between two samples"


@dataclass(frozen=True, eq=False)
class Report:
    """A check of a path, a trajectory (``timed``) or a task, whose ``parts`` are its segments; true if usable.

    The ``checker`` is of the world, and samples are ``step`` metres of motion apart. ``pieces`` counts proofs by their
    verdict. ``clearance`` is the smallest one, None where no pair is checked. ``measures`` are data by name: sizes,
    lengths, w, shares of limits, results of constraints, and limits that were not judged.
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
        """Whether nothing speaks against running the motion; what could not be proven does not."""
        return not self.findings

    @property
    def proven(self) -> bool:
        """Whether every piece of the motion is proven free, within limits and keeping all constraints."""
        if self.parts:
            return self.ok and all(part.proven for part in self.parts)
        kept = all(each["proven"] for each in self.measures.get("constraints", ()))
        return self.ok and not self._undecided and not self.measures.get("not_judged") and kept

    @property
    def _undecided(self) -> int:
        """How many pieces are not proven free, of what stands or of what moves."""
        return self.measures.get("undecided", 0)

    @property
    def sentence(self) -> str:
        """Whether the motion is usable; if not, the first reason."""
        if self.parts:
            bad = sum(not part.ok for part in self.parts)
            wrong = f"{bad} of {len(self.parts)} segments are not free and within limits, or end wrongly."
            return wrong if bad else "All segments are free."
        if self.findings:
            return f"Not usable: {self.findings[0].sentence.rstrip('.')}."
        piece = "piece between two points" if self.timed else "segment"
        limits, unjudged = "all limits" if self.timed else "limits", ""
        if left_open := self.measures.get("not_judged", []):
            limits = f"the limits on {' and '.join(kind for kind in ('position', *KINDS) if kind not in left_open)}"
            jump = self.measures["jump"]
            unjudged = f"; {' and '.join(left_open)} not judged, as {jump} and the limit is merely assumed"
        horizon = f" With what may move: {self._horizon()}." if "horizon" in self.measures else ""
        if self._undecided:
            left = f"{count_text(self._undecided, piece.split()[0])} could not be proven"
            return f"Free and within {limits} wherever it was sampled; {left}{unjudged}.{horizon}"
        return f"Free and within {limits}; every {piece} is proven free as a whole{unjudged}.{horizon}"

    def rows(self) -> list[tuple[str, str]]:
        """The report as the table of the terminal."""
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
        open_text = f"infinite, as {m.get('jump')}; not judged, as the limit is merely assumed"
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
        rows.append(("manipulability w", f"{least}, frame {self.checker.robot.tool}"))
        for each in m["constraints"]:
            proof = "proven all along" if each["proven"] else "NOT proven between what was sampled"
            spare = f"'{each['condition']}' with {each['spare']:.3g} {each['unit']} to spare"
            rows += [] if each["strays"] else [("kept", f"{spare}, {proof}, least {self._at(each['at'])}")]
        return rows

    def _size(self) -> str:
        m = self.measures
        size = count_text(m["points"], "point" if self.timed else "waypoint")
        if "duration" in m:
            late = f", beginning {m['begin']:.3f} s after the start" if m["begin"] > 0 else ""
            return f"{size}, {m['duration']:.3f} s{late}, run as {m['interpolation']} between them"
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
        """Until when unknown motions cannot matter, as part of a sentence."""
        until, limits = (self.measures["horizon"][name] for name in ("free_until", "speed_limits"))
        within = choices(f"{name} below {limit:g} m/s" for name, limit in limits.items())
        return f"no contact {'at any time' if until is None else f'before {until:.3f} s'}, whatever these do: {within}"

    def _line(self) -> str:
        """What is said of a segment of a task."""
        allowed = "".join(f"; '{a}' may touch '{b}'" for a, b in self.measures["may_touch"])
        return ("; ".join(each.sentence.rstrip(".") for each in self.findings) or "free") + allowed

    def to_dict(self) -> dict[str, Any]:
        """As plain data: s, rad and m; places on a path in segments from 0."""
        world = self.checker.world
        found = {"ok": self.ok, "message": self.sentence, "robot": world.robot.name, "scene": world.scene.name}
        found |= {"joints": list(world.robot.joints), "frame": world.robot.tool, "collision": self.checker.name}
        found |= {"margin": world.margin, "step": self.step, "proven": self.proven, "notes": list(self.notes)}
        if self.parts:
            return found | {"segments": [{"title": part.title, **part.to_dict()} for part in self.parts]}
        findings = [each.to_dict() for each in self.findings]
        clearance = None if self.clearance is None else self.clearance.to_dict()
        return found | {"findings": findings, "pieces": self.pieces, "clearance": clearance} | self.measures


def count_text(number: int, thing: str) -> str:
    """ "1 edge", "2 edges"."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def floor_text(floor: dict[str, Any]) -> str:
    """What ``proof.floor`` of a trajectory says of w in motion, as part of a sentence."""
    above, exempt, below = (floor[f"pieces_{name}"] for name in ("above", "exempt", "below"))
    pieces, asked = count_text(above + exempt + below, "piece"), f"the floor of {floor['asked']:g}"
    if below:
        return f"w is NOT proven above {asked} in {below} of {pieces}"
    if not above:
        return f"nothing is proven of w: it never stays above {asked} from one of {pieces} to the next"
    ways = f"; the other {exempt} lead up from its start or down to its goal" if exempt else ""
    return f"w is proven above {asked} in {above} of {pieces}{ways}"
