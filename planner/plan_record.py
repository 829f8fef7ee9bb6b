"""What a plan writes: ``plan.json`` and ``roadmap.npz``; the page comes from :mod:`planner.view`."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from planner.base.files import write_json
from planner.base.outcome import Outcome
from planner.base.progress import rounded
from planner.costs.manipulability_floor import first_violation
from planner.kinematics.manipulability import manipulability
from planner.paths.measure import measure_path, path_manipulability
from planner.planning import Plan
from planner.roadmap.storage import save_roadmap
from planner.roadmap.summary import roadmap_record, roadmap_text
from planner.world.run_record import run_record


def plan_record(plan: Plan) -> dict[str, Any]:
    """The plan as plain data, the keys of ``plan.json``; units in rad, m and s."""
    return {
        **run_record(plan.request, plan.outcome, plan.robot, plan.scene),
        "path": plan.path.tolist(),
        "path_nodes": plan.path_nodes.tolist(),
        "goal": plan.goal,
        "cost": asdict(plan.cost) if plan.cost else None,
        **_measures(plan),
        "roadmap": roadmap_record(plan.roadmap, plan.edges_removed),
        "gabf": _gabf(plan),
        "timings_s": rounded(plan.timings),
    }


def save_plan(plan: Plan, folder: Path, timings: dict[str, float]) -> dict[str, Any]:
    """Write ``roadmap.npz`` and ``plan.json`` under ``folder``; returns the record that was written."""
    save_roadmap(plan.roadmap, folder / "roadmap.npz")
    record = plan_record(plan)
    record["timings_s"] |= rounded(timings)
    write_json(folder / "plan.json", record)
    return record


def _measures(plan: Plan) -> dict[str, Any]:
    """What is measured along the path; nothing where there is none."""
    if plan.outcome is not Outcome.SOLVED:
        return {"manipulability": None, "path_length": None}
    found, robot = measure_path(plan.robot, plan.path), plan.robot
    w = {"min": found.w_min, "mean": found.w_mean, "rows": robot.manipulability, "frame": robot.tool}
    lengths = {"joint": found.joint_length, "workspace": found.workspace_length}
    return {"manipulability": w | _floor(plan), "path_length": lengths}


def _floor(plan: Plan) -> dict[str, Any]:
    """What became of the floor that was asked for; nothing where none was."""
    floor = plan.request.min_manipulability
    if floor <= 0:
        return {}
    ends = [float(w) for w in manipulability(plan.robot, plan.path[[0, -1]])]
    holds = first_violation(plan.robot, plan.path, floor) is None
    reached = bool(path_manipulability(plan.robot, plan.path).max() >= floor)
    return {"floor": {"asked": floor, "start": ends[0], "goal": ends[1], "reached": reached, "holds": holds}}


def _gabf(plan: Plan) -> dict[str, Any] | None:
    if plan.cost_to_go is None:
        return None
    return {
        "law": plan.request.law,
        "prescribed_time": plan.request.prescribed_time,
        "settling_time": plan.cost_to_go.settling_time,
        "settling_tau": plan.cost_to_go.settling_tau,
        "log10_remaining": plan.cost_to_go.log10_remaining,
        "steps": plan.cost_to_go.steps,
        "residual": plan.cost_to_go.residual,
        "max_error_vs_oracle": plan.max_error_vs_oracle,
        "outcome": plan.cost_to_go.outcome.key,
        "certificate": [bound.to_dict() for bound in plan.certificate],
    }


def summary_rows(record: dict[str, Any]) -> list[tuple[str, str]]:
    """What the terminal's table and the page's panel say about a plan."""
    gabf, cost, w = (record[key] for key in ("gabf", "cost", "manipulability"))
    rows = [("roadmap", roadmap_text(record["roadmap"]))]
    if cost:
        rows.append(
            (
                "cost",
                f"{cost['total']:.4f} = {1 - cost['beta']:g} x {cost['manipulability']:.4f} manipulability"
                f" + {cost['beta']:g} x {cost['distance']:.4f} distance",
            )
        )
        rows.append(("manipulability w", f"min {w['min']:.5f}, mean {w['mean']:.5f} along the path" + _floor_text(w)))
        length = record["path_length"]
        rows.append(("goal reached", record["goal"]))
        rows.append(
            ("path", f"{len(record['path'])} waypoints, {length['joint']:.3f} rad, {length['workspace']:.3f} m")
        )
    if gabf:
        rows.append(("settled", _settling(gabf)))
        rows += _certified(gabf)
        rows.append(("error against oracle", f"{gabf['max_error_vs_oracle']:.1e} relative"))
    return rows


def _floor_text(w: dict[str, Any]) -> str:
    if "floor" not in w:
        return ""
    asked, ends = w["floor"]["asked"], min(w["floor"]["start"], w["floor"]["goal"])
    if not w["floor"]["holds"]:
        return f"; NOT above the floor of {asked:g}"
    if not w["floor"]["reached"]:
        return f"; it never reaches the floor of {asked:g}, and stays above its lower end's {ends:.5f}"
    low = "" if ends >= asked else f" but for the stretches from and to its ends, of w {ends:.5f}"
    return f"; above the floor of {asked:g}{low}"


def _certified(gabf: dict[str, Any]) -> list[tuple[str, str]]:
    """The sharpest bound on the settling time that is proven for this run."""
    proven = [c for c in gabf["certificate"] if c["quantity"] == "settling tau" and c["applies"] and c["proven"]]
    if not proven:
        return []
    best = min(proven, key=lambda c: c["bound"])
    remaining = best["log10_remaining"]
    ahead = "" if remaining is None else f", {10**remaining:.2g} s before T_p" if remaining > -300 else ", before T_p"
    return [("certified", f"to settle by tau = {best['bound']:.1f}{ahead} ({best['name']})")]


def _settling(gabf: dict[str, Any]) -> str:
    if gabf["settling_time"] is None:
        return "not within the budget"
    limit = f" of T_p = {gabf['prescribed_time']:g} s" if gabf["log10_remaining"] is not None else " s"
    return f"at t = {gabf['settling_time']:.4f}{limit} (tau = {gabf['settling_tau']:.2f}), law {gabf['law']}"
