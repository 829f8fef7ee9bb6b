"""A plan's record, the keys of ``plan.json``, as rows of a table: for the terminal, the page and notebooks."""

from __future__ import annotations

from typing import Any

from planner.base.errors import choices
from planner.roadmap.record_text import roadmap_text
from planner.search.manipulability_floor import rounded_down
from planner.trajectory.clearance import clearance_rows
from planner.trajectory.report import floor_text

CONDITIONING = "conditioning"  # the row that is there only where it is bad
_NOTABLE = 0.02  # share of a cost
_ROUNDING = 1e-9  # %, of a cost that is a sum


def summary_rows(record: dict[str, Any]) -> list[tuple[str, str]]:
    """What the terminal's table and the page's panel say about a plan."""
    field, cost, w = (record[key] for key in ("gabf", "cost", "manipulability"))
    rows = [("roadmap", roadmap_text(record["roadmap"]))]
    if cost:
        rows.append(("cost", cost_text(cost)))
        rows += _integral_rows(cost, record["quality"]["manipulability_cost"])
        rows += _quality_rows(record["quality"], bool(record["in_time"]))
        said = f"min {w['min']:.5f}, mean {w['mean']:.5f} along the path{_floor_text(w)}"
        rows.append(("manipulability w", said))
        if record["conditioning"] and record["conditioning"]["poor"]:
            rows.append((CONDITIONING, record["conditioning"]["advice"]))
        rows += clearance_rows(record["clearance"], record["config"]["room"])
        length = record["path_length"]
        rows.append(("goal reached", record["goal"]))
        rows.append(
            ("path", f"{len(record['path'])} waypoints, {length['joint']:.3f} rad, {length['workspace']:.3f} m")
        )
    if record.get("tool_path"):
        rows += _tool_path_rows(record)
    rows += [(leg["leg"], _leg_text(leg, _what_is_told(record))) for leg in record.get("legs") or ()]
    if record["trajectory"]:
        rows.append(("motion", _motion_text(record["trajectory"], bool(w and "floor" in w))))
    rows += [("kept", _kept_text(kept)) for kept in record["kept"]]
    if record["in_time"]:
        rows += _rows_in_time(record["in_time"], record["trajectory"])
    if field:
        rows += field_rows(field)
    return rows


def cost_text(cost: dict[str, Any]) -> str:
    """A path's cost and what it is the sum of."""
    beta = cost["beta"]
    parts = f"{1 - beta:g} x {cost['manipulability']:.4f} manipulability + {beta:g} x {cost['distance']:.4f} distance"
    return f"{cost['total']:.4f} = {parts}"


def field_rows(field: dict[str, Any]) -> list[tuple[str, str]]:
    """When a field settled, which bounds it meets, and how far it is from the oracle's."""
    error = f"{field['max_error_vs_oracle']:.1e} relative"
    return [("settled", _settling(field)), *_certified(field), ("error against oracle", error)]


def _leg_text(leg: dict[str, Any], what: str) -> str:
    """How long a straight line of the tool is, and how far the tool is off it."""
    off, tube = leg["largest_deviation"], leg["tube"]
    return (
        f"{leg['length']:.3g} m straight along the tool's z axis; {what} at most {1e3 * off['position']:.3g} mm "
        f"off where sampled, proven within {1e3 * tube['position']:g} mm and {tube['angle']:g} rad"
    )


def _what_is_told(record: dict[str, Any]) -> str:
    """What deviations are told of."""
    return "path and motion" if record["trajectory"] else "path"


def _tool_path_rows(record: dict[str, Any]) -> list[tuple[str, str]]:
    """How much of a tool path is followed, how far the tool is off it, and how fast it goes."""
    found = record["tool_path"]
    off, tube = found["largest_deviation"], found["tube"]
    what, proof = _what_is_told(record), "proven within" if found["proven"] else "NOT proven within"
    stops = "" if found["first_unreachable"] is None else f", not to point {found['first_unreachable']}"
    text = f"{100 * found['followed']:.1f} % of {found['points']} points followed{stops}"
    if found["followed"] > 0:
        text += (
            f"; {what} at most {1e3 * off['position']:.3g} mm and {off['angle']:.2g} rad off where sampled, "
            f"{proof} {1e3 * tube['position']:g} mm and {tube['angle']:g} rad"
        )
    rows, speed = [("tool path", text)], found.get("speed")
    if speed:
        share = f"{100 * speed['share']:.1f} % of it at the {speed['asked']:g} m/s asked for"
        rows.append(("tool speed", f"{share}, nowhere above {speed['largest']:.6g} m/s"))
    return rows


def _quality_rows(quality: dict[str, Any], in_time: bool) -> list[tuple[str, str]]:
    """The bound on the cost, and what the effort gained; ``in_time`` it is not the cost that decides."""
    bound, gap = quality["lower_bound"], quality["gap"]
    ends, apart = "between the roadmap's start and goal configurations", ""
    if gap is not None and not in_time:
        share = max(0.0, 100 * gap - _ROUNDING)
        apart = f"; this path is at most {_outward(share, 1, up=True)} % above the optimum between them"
    rows = [("bound", f"no path {ends} costs less than {_outward(bound, 4, up=False)}{apart}")]
    costs = [point["cost"] for point in quality["curve"]]
    if len(costs) > 1:
        rounds = quality["curve"][-1]["rounds"]
        rows.append(("effort", f"{rounds} rounds took the best cost from {costs[0]:.4f} to {costs[-1]:.4f}"))
    return rows


def _integral_rows(cost: dict[str, Any], finely: float | None) -> list[tuple[str, str]]:
    """How much more a path costs in short pieces, where that is worth a word."""
    if finely is None or cost["beta"] == 1.0 or finely <= (1.0 + _NOTABLE) * cost["manipulability"]:
        return []
    more = 100 * (finely / cost["manipulability"] - 1.0)
    return [
        ("integral", f"{finely:.4f} manipulability in pieces of 0.01 rad, {more:.1f} % more: w dips between states")
    ]


def _motion_text(motion: dict[str, Any], floored: bool) -> str:
    corners = "from rest to rest, the earliest through the roadmap"
    if "corners" in motion:
        corners = (
            f"{motion['corners_blended']} of {motion['corners']} corners rounded, shortcuts: {motion['shortcuts']}"
        )
    proof = "proven free and within limits" if motion["proven"] else "NOT proven as a whole"
    above = f"{floor_text(motion['floor'])}; " if floored and motion["floor"] else ""
    return f"{motion['duration']:.3f} s, {corners}, {proof}; {above}{motion['limits']}"


def _kept_text(kept: dict[str, Any]) -> str:
    """What path and motion have to spare of a condition."""

    def proof(proven: bool) -> str:
        return "proven" if proven else "NOT proven"

    text = (
        f"{kept['condition']}: {kept['path']:.3g} {kept['unit']} to spare along the path, {proof(kept['path_proven'])}"
    )
    if kept["motion"] is None:
        return text
    return f"{text}; {kept['motion']:.3g} {kept['unit']} in motion, {proof(kept['motion_proven'])}"


def _rows_in_time(in_time: dict[str, Any], motion: dict[str, Any]) -> list[tuple[str, str]]:
    """How the motion keeps clear of what moves, and until when what may move cannot touch."""
    rows, times, horizon = [], in_time["waypoints"], in_time["horizon"]
    if times:
        waits = sum(times["departures"]) - sum(times["arrivals"])
        stands = f"it stands {waits:.3f} s on the way" if waits > 0 else "it need not wait"
        clear = "proven clear" if motion["proven"] else "NOT proven clear"
        rows.append(("known motions", f"{clear} of {choices(in_time['moving'])}; {stands}"))
    if horizon:
        limits = choices(f"{name} below {limit:g} m/s" for name, limit in horizon["speed_limits"].items())
        until = horizon["free_until"]
        when = "at any time" if until is None else f"before {until:.3f} s"
        rows.append(("horizon", f"no contact {when}, whatever these do: {limits}"))
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


def _certified(field: dict[str, Any]) -> list[tuple[str, str]]:
    """The sharpest bound on the settling time that is proven for this run."""
    proven = [c for c in field["certificate"] if c["quantity"] == "settling tau" and c["applies"] and c["proven"]]
    finite = [c for c in proven if c["bound"] is not None]
    if not finite:
        return []
    best = min(finite, key=lambda c: c["bound"])
    remaining = best["log10_remaining"]
    ahead = "" if remaining is None else ", before T_p"
    if remaining is not None and remaining > -300:
        ahead = f", {rounded_down(10**remaining):.2g} s before T_p"
    return [("certified", f"to settle by tau = {_outward(best['bound'], 1, up=True)}{ahead} ({best['name']})")]


def _outward(bound: float, digits: int, *, up: bool) -> str:
    """A bound with so many digits behind the point, nowhere sharper than it is."""
    text, step = f"{bound:.{digits}f}", 10.0**-digits
    if up:
        return f"{bound + step:.{digits}f}" if float(text) < bound else text
    return f"{bound - step:.{digits}f}" if float(text) > bound else text


def _settling(field: dict[str, Any]) -> str:
    if field["settling_time"] is None:
        return "not within the budget"
    limit = f" of T_p = {field['prescribed_time']:g} s" if field["log10_remaining"] is not None else " s"
    time = f"{field['settling_time']:{'.4f' if field['settling_time'] >= 0.1 else '.4g'}}"
    rough = "; not enclosed: too many steps" if field["settling_tau_bracket"][1] is None else ""
    return f"at t = {time}{limit} (tau = {field['settling_tau']:.2f}), law {field['law']}{rough}"
