"""What a checked path's report says, as rows of text and as plain data."""

from __future__ import annotations

from typing import Any

import numpy as np

from planner.collision.checker import CollisionChecker
from planner.collision.edge_prover import Verdict
from planner.collision.world import Contact
from planner.constraints.keeps import Kept
from planner.query.resolve import DEGREES
from planner.robot.robot import Robot
from planner.trajectory.path_check import Excess, PathReport
from planner.trajectory.path_clearance import CLOSE, TOO_CLOSE, TOO_CLOSE_TEXT, Place, clearance_text

_PROFILE = 101  # places of the w profile in the record


def verdict_sentence(report: PathReport) -> str:
    """Whether the path is usable, in one sentence; if not, the first reason."""
    if report.degrees:
        return f"Not usable: {_limits(report)}: {DEGREES}"
    if report.excess is not None:
        return f"Not usable: {_limits(report)}."
    if report.contact is not None or report.proven.strikes is not None:
        return f"Not usable: {_contact(report)}."
    if not report.ok:
        return f"Not usable: {next(text for text, kept in kept_texts(report) if kept.strays)}."
    undecided = report.proven.count(Verdict.UNDECIDED)
    if not undecided:
        return "Free and within limits; every segment is proven free as a whole."
    return f"Free and within limits wherever it was sampled; {counted(undecided, 'segment')} could not be proven."


def report_rows(report: PathReport) -> list[tuple[str, str]]:
    """The report as the terminal's table has it."""
    if report.degrees:
        return [("path", counted(len(report.path), "waypoint")), ("joint limits", _limits(report))]
    robot, w = report.checker.robot, report.w
    size = f"{counted(len(report.path), 'waypoint')}, {report.joint_length:.3f} rad, {report.workspace_length:.3f} m"
    smallest = f"min {w.min():.3g} ({_where(report.lowest.segment, report.lowest.share)}), mean {w.mean():.3g}"
    return [
        ("path", size),
        ("joint limits", _limits(report)),
        ("first contact", _contact(report) + _configuration(report)),
        ("smallest clearance", _clearance(report)),
        *([(TOO_CLOSE, TOO_CLOSE_TEXT)] if report.ok and report.clearance and report.clearance.value < CLOSE else []),
        ("proofs", _proofs(report)),
        ("manipulability w", f"{smallest}, frame {robot.tool}"),
        *(("kept", text) for text, _ in kept_texts(report)),
    ]


def kept_texts(report: PathReport) -> list[tuple[str, Kept]]:
    """What came of each condition, as part of a sentence."""
    return [(f"{kept.text}, least in {_where(place.segment, place.share)}", kept) for kept, place in report.kept]


def circumstances(checker: CollisionChecker, step: float) -> dict[str, Any]:
    """What a path or a trajectory was checked against, as plain data; ``step`` (m) between two samples."""
    world = checker.world
    return {
        "robot": world.robot.name,
        "scene": world.scene.name,
        "joints": list(world.robot.joints),
        "collision": checker.name,
        "margin": world.margin,
        "step": step,
    }


def report_record(report: PathReport) -> dict[str, Any]:
    """The report as plain data; segments and waypoints count from 0, units are rad and m."""
    places = np.linspace(0.0, 1.0, _PROFILE)
    return {
        "ok": report.ok,
        "message": verdict_sentence(report),
        **circumstances(report.checker, report.step),
        "waypoints": len(report.path),
        "path_length": {"joint": report.joint_length, "workspace": report.workspace_length},
        "limits": None if report.excess is None else vars(report.excess),
        "degrees": report.degrees,
        "contact": _contact_record(report),
        "clearance": _clearance_record(report),
        "segments": {verdict.name.lower(): report.proven.count(verdict) for verdict in Verdict},
        "kept": [kept_record(kept) | _place_record(place) for kept, place in report.kept],
        "manipulability": {
            "min": float(report.w.min()),
            "mean": float(report.w.mean()),
            **_place_record(report.lowest),
            "rows": report.checker.robot.manipulability,
            "frame": report.checker.robot.tool,
            "profile": np.interp(places, report.shares, report.w).tolist(),
        },
    }


def kept_record(kept: Kept) -> dict[str, Any]:
    """What came of a condition, as plain data."""
    condition = kept.condition
    return {"condition": condition.text, "unit": condition.unit, "spare": kept.spare, "proven": kept.proven}


def counted(number: int, thing: str) -> str:
    """ "1 edge", "2 edges"."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def _where(segment: int, share: float) -> str:
    return f"segment {segment + 1} at {100 * share:.1f} %"


def _limits(report: PathReport) -> str:
    return "within limits" if report.excess is None else excess_text(report.checker.robot, report.excess)


def excess_text(robot: Robot, excess: Excess) -> str:
    """Which waypoint is beyond which limit, as part of a sentence."""
    k = robot.joints.index(excess.joint)
    unit = "m" if robot.prismatic[k] else "rad"
    return (
        f"waypoint {excess.row + 1} puts joint '{excess.joint}' at {excess.value:.6g}, {excess.beyond:.3g} {unit} "
        f"outside [{robot.lower[k]:.6g}, {robot.upper[k]:.6g}]"
    )


def _contact(report: PathReport) -> str:
    margin = report.checker.world.margin
    if report.contact is not None:
        how = report.contact.contact.how(margin)
        return f"{report.contact.contact} {how} in {_where(report.contact.segment, report.contact.share)}"
    if report.proven.strikes is not None:
        segment, pair = report.proven.strikes
        every = f"every {1000 * report.step:g} mm"
        return f"{pair} {pair.how(margin)} in segment {segment + 1}, between two samples at {every}"
    return f"none, sampled every {1000 * report.step:g} mm of motion"


def _configuration(report: PathReport) -> str:
    return "" if report.contact is None else f", q:{','.join(f'{value:.4f}' for value in report.contact.q)}"


def _clearance(report: PathReport) -> str:
    place = report.clearance
    if place is None:
        return "there is nothing to come near to"
    words = "none" if not report.ok and place.value == 0.0 else clearance_text(place.value)
    return f"{words}, {report.nearest} in {_where(place.segment, place.share)}"


def _proofs(report: PathReport) -> str:
    proven, total = report.proven.count(Verdict.FREE), len(report.proven.verdicts)
    text = f"{proven} of {counted(total, 'segment')} proven free as a whole"
    return f"{text}, to keep {1000 * report.proven.bound:.2f} mm from everything" if report.proven.bound else text


def _contact_record(report: PathReport) -> dict[str, Any] | None:
    if (touch := report.contact) is not None:
        return {"segment": touch.segment, "share": touch.share, "q": touch.q.tolist(), "pair": _pair(touch.contact)}
    if report.proven.strikes is not None:
        segment, pair = report.proven.strikes
        return {"segment": segment, "share": None, "q": None, "pair": _pair(pair)}
    return None


def _clearance_record(report: PathReport) -> dict[str, Any] | None:
    if report.clearance is None:
        return None
    return {
        "smallest": report.clearance.value,
        **_place_record(report.clearance),
        "pair": _pair(report.nearest),
        "proven": report.proven.bound,
    }


def _place_record(place: Place) -> dict[str, Any]:
    return {"segment": place.segment, "share": place.share, "q": place.q.tolist()}


def _pair(contact: Contact | None) -> list[str] | None:
    return None if contact is None else [contact.first, contact.second]
