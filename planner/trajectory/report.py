"""What a checked trajectory's report says, as rows of text and as plain data."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from planner.base.errors import choices
from planner.collision.edge_prover import Verdict
from planner.constraints.keeps import Kept
from planner.query.resolve import DEGREES
from planner.trajectory.check import TrajectoryReport
from planner.trajectory.clearance import check_rows
from planner.trajectory.jumps import Jump
from planner.trajectory.limits import KINDS, UNITS
from planner.trajectory.moving_obstacles import TimeProof
from planner.trajectory.path_report import circumstances, counted, kept_record
from planner.trajectory.proof import Excess


def verdict_sentence(report: TrajectoryReport) -> str:
    """Whether the trajectory is usable, in one sentence; if not, the first reason."""
    if report.fault:
        return f"Not usable: {report.fault}."
    if report.degrees:
        return f"Not usable: positions are beyond the joint limits: {DEGREES}"
    assert report.proof is not None
    if report.proof.excesses:
        return f"Not usable: {excess_text(report, report.proof.excesses[0])}."
    if report.contact is not None:
        return f"Not usable: {_contact(report)}."
    if not report.ok:
        return f"Not usable: {next(text for text, kept in _kept(report) if kept.strays)}."
    undecided = int(((report.proof.verdict == Verdict.UNDECIDED) | ~report.proof.in_time.free).sum())
    horizon = f" With what may move: {_horizon(report.proof.in_time)}." if report.proof.in_time.limits else ""
    limits, unjudged = "all limits", ""
    if report.proof.unjudged and report.proof.jump:
        judged = [kind for kind in ("position", *KINDS) if kind not in report.proof.unjudged]
        limits = f"the limits on {' and '.join(judged)}"
        left_open = " and ".join(report.proof.unjudged)
        unjudged = f"; {left_open} not judged, as {_jump(report, report.proof.jump)} and nobody gives a limit"
    if not undecided:
        whole = "every piece between two points is proven free as a whole"
        return f"Free and within {limits}, at every moment; {whole}{unjudged}.{horizon}"
    left = f"{counted(undecided, 'piece')} could not be proven"
    return f"Within {limits}, and free wherever it was sampled; {left}{unjudged}.{horizon}"


def report_rows(report: TrajectoryReport) -> list[tuple[str, str]]:
    """The report as the terminal's table has it."""
    size = counted(len(report.points.times), "point")
    rows = [("limits", report.limits.text(report.checker.robot))]
    if report.fault:
        return [("trajectory", size), ("times", report.fault), *rows]
    if report.trajectory is None or report.proof is None:
        return [("trajectory", size), ("joint limits", DEGREES), *rows]
    found = report.trajectory
    begin = f", beginning {found.times[0]:.3f} s after the start" if found.times[0] > 0 else ""
    rows = [("trajectory", f"{size}, {found.duration:.3f} s{begin}, run as {found.interpolation} between them"), *rows]
    rows += [("note", note) for note in _notes(report)]
    broken = {excess.kind: excess for excess in report.proof.excesses}
    rows.append(("joint limits", excess_text(report, broken["position"]) if "position" in broken else "within limits"))
    for order, kind in enumerate(KINDS, start=1):
        share = _share(report, order, kind)
        text = "" if share is None else f"{100 * share:.1f} % of the limit at most"
        if report.proof.jump and kind in report.proof.unjudged:
            text = f"infinite, as {_jump(report, report.proof.jump)}; not judged, as nobody gives a limit"
        rows.append((kind, excess_text(report, broken[kind]) if kind in broken else text))
    rows.append(("first contact", _contact(report)))
    rows += check_rows(report.nearest, report.contact is not None, "s")
    proven = int((report.proof.verdict == Verdict.FREE).sum())
    rows.append(("proofs", f"{proven} of {counted(len(report.proof.verdict), 'piece')} proven free as a whole"))
    rows += _rows_in_time(report.proof.in_time)
    if report.w is not None and report.w_times is not None:
        at = report.w_times[report.w.argmin()]
        text = f"min {report.w.min():.3g} (at {at:.3f} s), mean {report.w.mean():.3g}"
        rows.append(("manipulability w", f"{text}, frame {report.checker.robot.tool}"))
    return rows + [("kept", text) for text, _ in _kept(report)]


def _kept(report: TrajectoryReport) -> list[tuple[str, Kept]]:
    """What came of each condition, as part of a sentence."""
    times = report.w_times
    return (
        [(f"{each.text}, least at {times[each.row]:.3f} s", each) for each in report.kept] if times is not None else []
    )


def _rows_in_time(proof: TimeProof) -> list[tuple[str, str]]:
    """What moves, and what is proven of it; nothing where nothing moves."""
    rows = []
    if proof.moving:
        text = f"{int(proof.free.sum())} of {counted(len(proof.free), 'piece')} proven clear of {choices(proof.moving)}"
        rows.append(("known motions", text))
    if proof.limits:
        rows.append(("horizon", _horizon(proof)))
    return rows


def _horizon(proof: TimeProof) -> str:
    """Until when unknown motions cannot matter, as part of a sentence."""
    within = choices(f"{name} below {limit:g} m/s" for name, limit in proof.limits.items())
    if not np.isfinite(proof.free_until):
        return f"no contact at any time, whatever these do: {within}"
    return f"no contact before {proof.free_until:.3f} s, whatever these do: {within}"


def report_record(report: TrajectoryReport) -> dict[str, Any]:
    """The report as plain data; s, rad, m."""
    found, proof = report.trajectory, report.proof
    record: dict[str, Any] = {
        "ok": report.ok,
        "message": verdict_sentence(report),
        **circumstances(report.checker, report.step),
        "points": len(report.points.times),
        "fault": report.fault,
        "degrees": report.degrees,
        "limits": report.limits.to_dict(),
        "notes": _notes(report),
    }
    if found is None or proof is None or report.w is None:
        return record
    return record | {
        "duration": found.duration,
        "interpolation": found.interpolation,
        "shares": {kind: _share(report, order, kind) for order, kind in enumerate(KINDS, start=1)},
        "exceeded": [
            asdict(excess) | {"value": excess.value if np.isfinite(excess.value) else None} for excess in proof.excesses
        ],
        "jump": None if proof.jump is None else asdict(proof.jump),
        "not_judged": list(proof.unjudged),
        "contact": _contact_record(report),
        "clearance": None if report.nearest is None else report.nearest.to_dict(),
        "pieces": {verdict.name.lower(): int((proof.verdict == verdict).sum()) for verdict in Verdict},
        "kept": [kept_record(each) for each in report.kept],
        "manipulability": {"min": float(report.w.min()), "mean": float(report.w.mean())},
        **proof.in_time.to_dict(),
    }


def floor_text(floor: dict[str, Any]) -> str:
    """What ``proof.floor`` of a trajectory says of w in motion, as part of a sentence."""
    above, exempt, below = (floor[f"pieces_{name}"] for name in ("above", "exempt", "below"))
    pieces, asked = counted(above + exempt + below, "piece"), f"the floor of {floor['asked']:g}"
    if below:
        return f"w is NOT proven above {asked} in {below} of {pieces}"
    if not above:
        return f"nothing is proven of w: it never stays above {asked} from one of {pieces} to the next"
    ways = f"; the other {exempt} lead up from its start or down to its goal" if exempt else ""
    return f"w is proven above {asked} in {above} of {pieces}{ways}"


def excess_text(report: TrajectoryReport, excess: Excess) -> str:
    """Which joint breaks which limit by how much and when, as part of a sentence."""
    robot = report.checker.robot
    unit = ("m" if robot.prismatic[robot.joints.index(excess.joint)] else "rad") + UNITS.get(excess.kind, "")
    times = f"between {excess.begin:.3f} and {excess.end:.3f} s"
    if excess.kind == "position":
        return (
            f"joint '{excess.joint}' is at {excess.value:.6g} {times}, {abs(excess.value - excess.limit):.3g} {unit} "
            f"beyond its limit of {excess.limit:.6g}"
        )
    if not np.isfinite(excess.value) and report.proof is not None and report.proof.jump is not None:
        remedy = {"lines": "; give velocities too", "cubics": "; give accelerations too"}
        also = "" if report.trajectory is None else remedy.get(report.trajectory.interpolation, "")
        infinite = f"an infinite {excess.kind} where the limit is {excess.limit:g} {unit}"
        return f"{_jump(report, report.proof.jump)}: {infinite}{also}"
    more = 100 * (excess.value / excess.limit - 1)
    return (
        f"joint '{excess.joint}' reaches {excess.value:.6g} {unit} of {excess.kind} {times}, {more:.3g} % over its "
        f"limit of {excess.limit:g}"
    )


def _jump(report: TrajectoryReport, jump: Jump) -> str:
    """Which joint jumps by how much and when, as part of a sentence."""
    robot = report.checker.robot
    unit = ("m" if robot.prismatic[robot.joints.index(jump.joint)] else "rad") + UNITS[jump.what]
    largest = "" if jump.count == 1 else f" (the largest of {jump.count} jumps)"
    return f"the {jump.what} of joint '{jump.joint}' jumps by {jump.size:.4g} {unit} at {jump.time:.3f} s{largest}"


def _notes(report: TrajectoryReport) -> list[str]:
    """What of the file is left aside, and what is not known of its beginning."""
    return [*report.points.notes, *report.points.beginning()]


def _share(report: TrajectoryReport, order: int, kind: str) -> float | None:
    """The largest share of a limit that is used; None where a jump makes it infinite."""
    found, proof = report.trajectory, report.proof
    if found is None or proof is None or (proof.jump is not None and kind in proof.jump.infinite):
        return None
    return found.worst(order, getattr(report.limits, kind))[0]


def _contact(report: TrajectoryReport) -> str:
    found = report.contact
    if found is None:
        return f"none, sampled every {1000 * report.step:g} mm of motion"
    how = f"{found.contact} {found.contact.how(report.checker.world.margin)}"
    if found.q is None:
        return f"{how} between {found.begin:.4f} and {found.end:.4f} s"
    return f"{how} at {found.begin:.4f} s, q:{','.join(f'{value:.4f}' for value in found.q)}"


def _contact_record(report: TrajectoryReport) -> dict[str, Any] | None:
    found = report.contact
    if found is None:
        return None
    pair = [found.contact.first, found.contact.second]
    return {"begin": found.begin, "end": found.end, "pair": pair, "q": None if found.q is None else found.q.tolist()}
