"""Certificates changed at random, and by an adversary who looks for the largest change that is still accepted."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from planner.certificate import PROOF_NAME, verify_proof

Data = dict[str, Any]
Rng = np.random.Generator
WITNESSES = ("piece", "pair", "low", "high", "normal")
DERIVED = ("piece", "pair", "low", "pairs", "exempt", "shapes")  # from what the file holds
_STEPS = 30  # of a climb
_SPECIAL = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e-300, 1e300)


@dataclass(frozen=True, eq=False)
class Case:
    """A folder with a plan and its certificate, and what they hold."""

    folder: Path
    data: Data
    meta: dict[str, Any]
    plan: dict[str, Any]
    motion: dict[str, Any] | None

    @staticmethod
    def from_folder(folder: Path) -> Case:
        """The case in a folder."""
        data, words = verify_proof.read(folder / PROOF_NAME)
        verify_proof.assign_witnesses(data, words, verify_proof.curves(data))
        motion = folder / "trajectory.json"
        record = json.loads(motion.read_text()) if motion.exists() else None
        return Case(folder, data, words, json.loads((folder / "plan.json").read_text()), record)

    def accepts(self, data: Data, words: dict[str, Any], follow: bool = True) -> str | None:
        """What the checker says of other contents, None where it refuses them.

        ``follow``: what plan.json and trajectory.json say of path and motion follows the certificate.
        """
        meta = np.frombuffer(json.dumps(words).encode(), dtype=np.uint8)
        held = {name: array for name, array in data.items() if name not in DERIVED}
        np.savez(self.folder / PROOF_NAME, **{**held, "meta": meta})
        plan, motion = self.plan, self.motion
        if follow:
            start, goal = ("q:" + ",".join(map(repr, q)) for q in data["path"][[0, -1]].tolist())
            config = {**plan["config"], "start": start, "goal": goal}
            plan = {**plan, "path": data["path"].tolist(), "config": config, "goal": goal}
            motion = motion and {**motion, **_points(data)}
        (self.folder / "plan.json").write_text(json.dumps(plan, default=str))
        if motion is not None:
            (self.folder / "trajectory.json").write_text(json.dumps(motion, default=str))
        try:
            with np.errstate(all="ignore"):
                return verify_proof.check(self.folder)
        except verify_proof.Refused:
            return None


def pack_witnesses(data: Data) -> Data:
    """The same witnesses, of which rows were changed, as the file has them: as many as there are of each piece."""
    order = np.lexsort((data["low"], data["piece"], data["pair"]))
    parts = np.zeros((int((data["left"] == verify_proof.PROVEN).sum()) + 1, data["parts"].shape[1]), dtype=np.int32)
    np.add.at(parts, (data["pair"], data["piece"]), 1)
    return {**data, **{name: data[name][order] for name in WITNESSES}, "parts": parts}


def _points(data: Data) -> dict[str, Any]:
    keys, clock, knots = ("q", "qd", "qdd"), data["clock"], data["knots"]
    if knots.ndim != 3 or len(knots) > len(keys) or clock.shape != knots.shape[1:2]:
        return {}
    rows = [{key: knots[c][k].tolist() for c, key in enumerate(keys[: len(knots)])} for k in range(len(clock))]
    return {"points": [{"t": t / 1e9, **row} for t, row in zip(clock.tolist(), rows, strict=True)]}


def mutate(case: Case, rng: Rng) -> tuple[Data, dict[str, Any], str]:
    """Other contents, and what was changed."""
    data, words = {name: array.copy() for name, array in case.data.items()}, dict(case.meta)
    kind = rng.choice(list(_KINDS))
    _KINDS[kind](data, words, rng)
    return pack_witnesses(data) if kind in _OF_ROWS else data, words, str(kind)


def largest(case: Case, rng: Rng) -> tuple[Data, str] | None:
    """The largest change in a random direction that is still accepted, by bisection; None where the smallest is not."""
    name = str(rng.choice(["points", "shift", "radius", "path", "knots", "high", "normal"]))
    if not case.data[name].size:
        return None
    array, way = case.data[name], rng.normal(size=case.data[name].shape)
    if rng.random() < 0.5:  # one row alone
        way[np.arange(len(way)) != rng.integers(len(way))] = 0.0
    if name == "radius":
        way = np.abs(way)
    best, low, high = None, -12.0, 1.0  # powers of ten
    for _ in range(12):
        middle = 0.5 * (low + high)
        data = {**case.data, name: np.asarray(array + 10.0**middle * way, dtype=array.dtype)}
        if case.accepts(data, case.meta):
            best, low = data, middle
        else:
            high = middle
    return None if best is None else (best, name)


def climb_witnesses(case: Case, rng: Rng, margin: float) -> tuple[Data, dict[str, Any]]:
    """The witnesses, turned and halved until they nearly show a larger ``margin`` (m) than there is."""
    data, words = {name: array.copy() for name, array in case.data.items()}, case.meta
    data["margin"] = np.array(margin)
    pieces, of_w = verify_proof.curves(data), data["pair"] == len(data["pairs"])
    last = {name: data[name][of_w] for name in WITNESSES}
    data |= {name: data[name][~of_w] for name in WITNESSES}
    reach, spare = verify_proof.reaches(data, pieces)
    for _ in range(_STEPS):
        slack = _slack(data, pieces, reach)
        worst = int((slack - spare).argmin())
        tried = {name: data[name][[worst]] for name in WITNESSES}
        if rng.random() < 0.5:
            tried = {name: np.repeat(array, 2, axis=0) for name, array in tried.items()}
            tried["high"][0] = tried["low"][1] = rng.uniform(tried["low"][0], tried["high"][0])
        way = rng.normal(size=tried["normal"].shape) * np.linalg.norm(tried["normal"], axis=1, keepdims=True)
        tried["normal"] += (way * 10.0 ** rng.uniform(-7, -0.5)).astype(np.float32)
        if _slack(data | tried, pieces, reach).min() > slack[worst]:
            data |= {name: np.concatenate([np.delete(data[name], worst, axis=0), tried[name]]) for name in WITNESSES}
    return pack_witnesses(data | {name: np.concatenate([data[name], last[name]]) for name in WITNESSES}), words


def _slack(data: Data, pieces: Any, reach: Any) -> Any:
    """By how much (m) each witness shows more than that its pair does not touch."""
    apart, need = verify_proof.gaps_and_motions(data, pieces, reach, np.arange(len(data["piece"])))
    return apart - need


def _array_names(data: Data, kinds: str) -> list[str]:
    """The names of the arrays of these kinds that are in the file and not empty."""
    return [name for name in verify_proof.FIELDS if data[name].dtype.kind in kinds and data[name].size]


def _change_numbers(data: Data, words: dict[str, Any], rng: Rng, names: tuple[str, ...] = ()) -> None:
    array = data[name := str(rng.choice([name for name in _array_names(data, "f") if name in (names or data)]))]
    way = rng.normal(size=array.shape) * 10.0 ** rng.uniform(-12, 1)
    if rng.random() < 0.7:
        way.ravel()[np.arange(way.size) != rng.integers(way.size)] = 0.0
    data[name] = (array + way).astype(array.dtype)


def _nudge_interval(data: Data, words: dict[str, Any], rng: Rng) -> None:
    """The end of an interval moved by one number, or swapped with another."""
    a, b = rng.integers(len(data["high"]), size=2)
    if rng.random() < 0.2:
        data["high"][[a, b]] = data["high"][[b, a]]
    else:
        data["high"][a] = np.nextafter(data["high"][a], rng.choice([-1.0, 2.0]))


def _miscount(data: Data, words: dict[str, Any], rng: Rng) -> None:
    """Count a witness to the next polynomial piece or pair."""
    parts = data["parts"].ravel()
    a = rng.integers(len(parts))
    b = (a + rng.choice([1, -1, data["parts"].shape[1]])) % len(parts)
    by = rng.integers(1, 3)
    parts[a], parts[b] = parts[a] - by, parts[b] + by
    data["parts"] = parts.reshape(data["parts"].shape)


def _exempt(data: Data, words: dict[str, Any], rng: Rng) -> None:
    """Another reason, perhaps one pair for another."""
    a, b = rng.integers(len(data["left"]), size=2)
    if rng.random() < 0.5:
        data["left"][a] = rng.integers(256) if rng.random() < 0.3 else rng.integers(3)
    else:
        data["left"][[a, b]] = data["left"][[b, a]]


def _change_hash(data: Data, words: dict[str, Any], rng: Rng) -> None:
    key = rng.choice(list(words["identity"]))
    said = words["identity"][key]
    at = rng.integers(len(said))
    words["identity"] = {**words["identity"], key: said[:at] + rng.choice(list("0123456789abcdef")) + said[at + 1 :]}


def _insert_special(data: Data, words: dict[str, Any], rng: Rng) -> None:
    name = rng.choice(_array_names(data, "f"))
    with np.errstate(over="ignore"):
        data[name].ravel()[rng.integers(data[name].size)] = rng.choice(_SPECIAL)


def _change_integers(data: Data, words: dict[str, Any], rng: Rng) -> None:
    name = rng.choice(_array_names(data, "iu")[1:])  # but for meta
    array = data[name].reshape(-1)
    info = np.iinfo(array.dtype)
    k = rng.integers(array.size)
    choices = [
        array[k] + 1 if array[k] < info.max else 0,
        array[k] - 1 if array[k] > info.min else 0,
        0,
        info.max,
        info.min,
    ]
    array[k] = choices[rng.integers(len(choices))]
    array[k] = rng.choice(array) if rng.random() < 0.3 else array[k]


def _drop_witness(data: Data, words: dict[str, Any], rng: Rng) -> None:
    kept = np.ones(len(data["piece"]), dtype=bool)
    kept[rng.integers(len(kept))] = False
    for name in WITNESSES:
        data[name] = data[name][kept]


def _widen(data: Data, words: dict[str, Any], rng: Rng) -> None:
    """A wide interval in place of a neighbour's."""
    k = rng.integers(len(data["piece"]))
    if rng.random() < 0.5:
        data["low"][k], data["high"][k] = 0.0, 1.0
    same = (data["piece"] == data["piece"][k]) & (data["pair"] == data["pair"][k])
    same[k] = False
    for name in WITNESSES:
        data[name] = data[name][~same]
    data["low"][k - int(same[:k].sum())], data["high"][k - int(same[:k].sum())] = 0.0, 1.0


def _turn_plane(data: Data, words: dict[str, Any], rng: Rng) -> None:
    k, other = rng.integers(len(data["normal"]), size=2)
    data["normal"][k] = [-1, 1][rng.integers(2)] * data["normal"][other] + rng.normal(size=3) * 10.0 ** rng.uniform(
        -4, 1
    )


def _drop_pair(data: Data, words: dict[str, Any], rng: Rng) -> None:
    """A pair left out, with its witnesses, perhaps as one that is exempt."""
    gone = rng.integers(len(data["pairs"]))
    kept = data["pair"] != gone
    for name in WITNESSES:
        data[name] = data[name][kept]
    data["pair"] = data["pair"] - (data["pair"] > gone)
    at = np.flatnonzero(data["left"] == verify_proof.PROVEN)[gone]
    data["left"][at] = rng.integers(1, 4)
    if rng.random() < 0.3:
        data["left"] = np.delete(data["left"], at)


def _swap_rows(data: Data, words: dict[str, Any], rng: Rng) -> None:
    name = rng.choice([name for name in _array_names(data, "fiu")[1:] if data[name].ndim and len(data[name]) > 1])
    a, b = rng.integers(len(data[name]), size=2)
    data[name][[a, b]] = data[name][[b, a]]


def _cut_array(data: Data, words: dict[str, Any], rng: Rng) -> None:
    name = rng.choice([name for name in verify_proof.FIELDS if name != "meta" and data[name].ndim])
    data[name] = data[name][:-1] if rng.random() < 0.5 else data[name].astype(rng.choice(["f8", "f4", "i8", "c16"]))


def _change_words(data: Data, words: dict[str, Any], rng: Rng) -> None:
    key = rng.choice(list(words))
    words[key] = [None, "x", -1.0, [], {}, 2, True, float("nan"), 1e9][rng.integers(9)]


def _change_floor(data: Data, words: dict[str, Any], rng: Rng) -> None:
    """A higher floor, or one of other rows or of another tool."""
    what = rng.integers(5)
    if what < 2:
        data["floor"] = data["floor"] * (1.0 + 10.0 ** rng.uniform(-9, 0))
    elif what == 2:
        words["rows"] = str(rng.choice(["planar", "translation", "pose"]))
    elif what == 3:
        data["normal"][data["pair"] == len(data["pairs"])] = 1.0  # where nothing was claimed too
    else:
        data["tool"] = data["tool"] + rng.normal(size=(4, 4)) * 10.0 ** rng.uniform(-9, 0)


_KINDS: dict[str, Callable[[Data, dict[str, Any], Rng], None]] = {
    "a plane turned": _turn_plane,
    "an interval widened": _widen,
    "an interval's end moved": _nudge_interval,
    "witnesses counted otherwise": _miscount,
    "a pair left out": _drop_pair,
    "a witness left out": _drop_witness,
    "a waypoint": partial(_change_numbers, names=("path", "knots")),
    "a frame": partial(_change_numbers, names=("turn", "shift", "axis")),
    "a hull's vertex": partial(_change_numbers, names=("points", "radius")),
    "an exemption": _exempt,
    "a hash": _change_hash,
    "NaN and the like": _insert_special,
    "other numbers": _change_numbers,
    "whole numbers": _change_integers,
    "rows swapped": _swap_rows,
    "an array cut": _cut_array,
    "a floor": _change_floor,
    "words": _change_words,
}
_OF_ROWS = ("an interval widened", "a pair left out", "a witness left out")
