"""The base of plans, sweeps and task plans: record (their JSON file), table, page and files."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Generic, Self, TypeVar

from pydantic import Field

from planner import gabf
from planner.base.errors import Reason
from planner.base.files import StrPath, stage_files, write_json, write_whole
from planner.base.progress import Stopwatch, round_seconds
from planner.base.resources import versions
from planner.base.yamlfile import read_text, validate
from planner.certificate.certificate import PROOF_NAME, Certificate
from planner.problem.outcome import FORMAT_VERSION, Outcome, Record, Rows, html_table, require_readable_version
from planner.problem.request import Request, SweepQuality, TaskQuality
from planner.robot.clouds import CloudRecord, record_clouds
from planner.robot.robot import Robot
from planner.robot.robot_in_scene import notes
from planner.robot.scene import Scene
from planner.search.manipulability_floor import round_down
from planner.search.network import PathCost
from planner.trajectory.file import parse_json
from planner.trajectory.report import floor_text
from planner.trajectory.trajectory import Trajectory

JSON_NAME, PAGE_NAME, ROADMAP_NAME = "plan.json", "plan.html", "roadmap.npz"
_SECONDS = (
    "seconds per stage; `total` also counts the time between stages, until the last file is written; `record` measures "
    "the path and encloses the settling time, `files` writes the other files"
)
_CORNERS = ("corners", "corners_blended", "shortcuts")  # keys of a trajectory's proof


@dataclass(frozen=True, kw_only=True, eq=False)
class RunRecord(Record):
    """The outcome of a run, its options and the software versions."""

    # pydantic reads docstrings of a class's own fields only, and subclasses inherit these
    format_version: int
    outcome: Annotated[str, Field(description="solved, no_path, too_singular, partly_followed or interrupted")]
    message: Annotated[str, Field(description="the outcome as a sentence, with its reason and the remedy")]
    robot: str
    scene: str
    seed: int
    config: Annotated[dict[str, Any], Field(description="every option")]
    versions: Annotated[dict[str, str], Field(description="of the planner, Python and its libraries")]
    joints: Annotated[list[str], Field(description="planned joints, in the order of the columns of a path")]
    tool: str
    notes: Annotated[list[str], Field(description="remarks on the model and the start")]
    timings_s: Annotated[dict[str, float], Field(description=_SECONDS)]
    clouds: Annotated[list[CloudRecord] | None, Field(description="points that a sensor saw, null without any")] = None

    @classmethod
    def from_run(cls, run: Result[Any], robot: Robot, scene: Scene, **own: Any) -> Self:
        """Return the record of a run of ``robot`` in ``scene``; ``own`` are the fields of a subclass."""
        return cls(
            format_version=FORMAT_VERSION,
            outcome=run.outcome.key,
            message=run.message,
            robot=robot.name,
            scene=scene.name,
            seed=run.request.values()["seed"],
            config=run.request.config(),
            versions=versions(),
            joints=list(robot.joints),
            tool=robot.tool_text,
            notes=[*(note.text for note in notes(robot, scene)), *run.end_notes],
            timings_s=round_seconds(run.timings),
            clouds=record_clouds(scene.obstacles) or None,
            **own,
        )

    @property
    def rows(self) -> Rows:
        """The table of the page and of ``--verbose``."""
        return []

    @property
    def summary(self) -> Rows:
        """The table of the terminal and of notebooks: at most nine rows, and a row per segment of a task."""
        return self.rows


R = TypeVar("R", bound=RunRecord)


def read_record(kind: type[R], file: Path) -> R:
    """Read a record from a JSON file; :class:`FileError` if it is missing, damaged or of a later format."""
    where = f"plan {file}"
    data = parse_json(read_text(file, "plan"), where)
    if isinstance(data, dict):
        require_readable_version(data, where)
    return validate(kind, data, where)


@dataclass(frozen=True, eq=False)
class Result(ABC, Generic[R]):
    """Base of the result of a command; it has a table and a page, and saves itself in a folder.

    ``reason`` explains a missing path, ``end_notes`` are remarks on the start, ``timings`` are in s.
    """

    JSON: ClassVar[str] = JSON_NAME
    PAGE: ClassVar[str] = PAGE_NAME
    FILES: ClassVar[tuple[str, ...]]  # all files, in the order in which they replace those of an earlier run

    request: Request
    outcome: Outcome
    reason: Reason | None = field(default=None, kw_only=True)
    end_notes: tuple[str, ...] = field(default=(), kw_only=True)
    timings: dict[str, float] = field(default_factory=dict, kw_only=True)

    @cached_property
    @abstractmethod
    def record(self) -> R:
        """The content of the JSON file; units in rad, m and s."""

    @abstractmethod
    def page(self) -> str:
        """Return the page as self-contained HTML."""

    @abstractmethod
    def _write(self, folder: Path) -> None:
        """Write all files except page, proof and record into an empty folder."""

    def files(self, folder: Path) -> Sequence[str]:
        """Return the files that ``folder`` gets, in this order; a file that is not written is removed."""
        return self.FILES

    def certify(self) -> Certificate | None:
        """Return a certificate for an independent checker; None if there is no proof."""
        return None

    @property
    def message(self) -> str:
        """The outcome as one sentence; without a path its reason, if known."""
        return self.outcome.value if self.reason is None else self.reason.sentence

    @property
    def solved(self) -> bool:
        """Whether there is a path from start to goal."""
        return self.outcome is Outcome.SOLVED

    @property
    def seconds(self) -> float:
        """Duration of all stages together, s."""
        return sum(self.timings.values())

    def to_dict(self) -> dict[str, Any]:
        """Return the keys of the JSON file."""
        return self.record.to_dict()

    def _repr_html_(self) -> str:
        record = self.record
        return html_table(f"{record.robot} in {record.scene}. {record.message}", record.summary)

    def save(self, folder: StrPath, certificate: bool = False) -> None:
        """Write all files, page included, into ``folder``, which is created if needed.

        ``certificate`` adds ``proof.npz`` if there is a proof. Raises :class:`FileError` if a file cannot be written.
        """
        clock = Stopwatch(self.timings)
        self.save_page(Path(folder), self.save_without_page(Path(folder), clock, certificate), clock)

    def save_without_page(self, folder: Path, clock: Stopwatch | None = None, certificate: bool = False) -> R:
        """Write all files except the page, remove older ones, and return the record, written last.

        The record has the stages of ``clock`` and those of the run.
        """
        clock = clock or Stopwatch(self.timings)
        clock.seconds.update(self.timings)
        with stage_files(folder, self.files(folder)) as inner:
            with clock("files"):
                self._write(inner)
            if certificate:
                with clock("certificate"):
                    proof = self.certify()
                    if proof is not None:
                        proof.save(inner / PROOF_NAME)
            with clock("record"):
                record = self.record
            record = replace(record, timings_s=clock.record())
            write_json(inner / self.JSON, record.to_dict())
        return record

    def save_page(self, folder: Path, record: R, clock: Stopwatch) -> R:
        """Write the page, and the record with the seconds of ``clock``; return that record."""
        with clock("page"):
            write_whole(folder / self.PAGE, self.page().encode())
        record = replace(record, timings_s=clock.record())
        write_json(folder / self.JSON, record.to_dict())
        return record


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionRecord(Record):
    """The motion along the path, as in trajectory.json."""

    time_law: str
    duration: float
    """s"""
    limits: str
    corners: int | None = None
    corners_blended: int | None = None
    shortcuts: int | None = None
    proven: bool
    """whether every polynomial piece is proven free and within limits"""
    floor: dict[str, Any] | None
    """``proof.floor`` of trajectory.json"""

    @classmethod
    def from_trajectory(cls, trajectory: Trajectory | None, robot: Robot) -> Self | None:
        """Return the record of a trajectory; None without one."""
        if trajectory is None:
            return None
        limits, proof = "" if trajectory.limits is None else trajectory.limits.text(robot), trajectory.proof
        known = {key: proof[key] for key in _CORNERS if key in proof}
        known |= {"proven": trajectory.proven, "floor": proof.get("floor")}
        return cls(time_law=trajectory.time_law, duration=trajectory.duration, limits=limits, **known)

    def text(self, floored: bool) -> str:
        """Return the motion as a row of a table; ``floored`` adds the manipulability floor."""
        corners = "from rest to rest, the earliest through the roadmap"
        if self.corners is not None:
            corners = f"{self.corners_blended} of {self.corners} corners rounded, shortcuts: {self.shortcuts}"
        above = f"{floor_text(self.floor)}; " if floored and self.floor else ""
        return f"{self.duration:.3f} s, {corners}, {self.proof_text}; {above}{self.limits}"

    @property
    def proof_text(self) -> str:
        """Whether the motion is proven, in words."""
        return "proven free and within limits" if self.proven else "NOT proven as a whole"


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldRecord(Record):
    """How the GABF dynamics settled."""

    law: str
    prescribed_time: float
    """T_p, s"""
    settling_time: float | None
    """s"""
    settling_tau: float | None
    settling_tau_bracket: list[float | None] | None
    """proven earliest and latest, null if unknown; 0 and null for a field too large to be enclosed"""
    log10_remaining: float | None
    """log10 of T_p minus the settling time"""
    steps: int
    residual: float | None
    max_error_vs_oracle: float | None
    """relative, against Dijkstra's algorithm"""
    outcome: str
    certificate: list[dict[str, Any]]
    """bounds of the paper and of this planner with the measured values, see :class:`planner.gabf.Certificate`"""

    @classmethod
    def from_field(cls, quality: SweepQuality | TaskQuality, field: gabf.CostToGo | None) -> Self | None:
        """Return the record of a field, with its bounds and its error against Dijkstra's algorithm."""
        if field is None:
            return None
        bracket = field.settling_tau_bracket
        return cls(
            law=quality.law,
            prescribed_time=quality.prescribed_time,
            settling_time=field.settling_time,
            settling_tau=field.settling_tau,
            settling_tau_bracket=None if bracket is None else [tau if math.isfinite(tau) else None for tau in bracket],
            log10_remaining=field.log10_remaining,
            steps=field.steps,
            residual=field.residual,
            max_error_vs_oracle=gabf.max_error(field, gabf.oracle(field.network)),
            outcome=field.outcome.key,
            certificate=[bound.to_dict() for bound in gabf.certify(field.network, field.law, field)],
        )

    @property
    def rows(self) -> Rows:
        """Rows for the settling time, its sharpest proven bound, and the error against the oracle."""
        rows, error = [("settled", self._settling)], f"{self.max_error_vs_oracle:.1e} relative"
        of_settling = [c for c in self.certificate if c["quantity"] == "settling tau" and c["applies"] and c["proven"]]
        best = min((c for c in of_settling if c["bound"] is not None), key=lambda c: c["bound"], default=None)
        if best is not None:
            remaining = best["log10_remaining"]
            ahead = "" if remaining is None else ", before T_p"
            if remaining is not None and remaining > -300:
                ahead = f", {round_down(10**remaining):.2g} s before T_p"
            rows.append(
                ("certified", f"to settle by tau = {outward(best['bound'], 1, up=True)}{ahead} ({best['name']})")
            )
        return [*rows, ("error against oracle", error)]

    @property
    def _settling(self) -> str:
        if self.settling_time is None:
            return "not within the budget"
        limit = f" of T_p = {self.prescribed_time:g} s" if self.log10_remaining is not None else " s"
        time = f"{self.settling_time:{'.4f' if self.settling_time >= 0.1 else '.4g'}}"
        bracket = self.settling_tau_bracket
        rough = "; not enclosed: too many steps" if bracket and bracket[1] is None else ""
        return f"at t = {time}{limit} (tau = {self.settling_tau:.2f}), law {self.law}{rough}"


def cost_text(cost: PathCost) -> str:
    """Return the cost of a path and its two summands as text."""
    beta = cost.beta
    parts = f"{1 - beta:g} x {cost.manipulability:.4f} manipulability + {beta:g} x {cost.distance:.4f} distance"
    return f"{cost.total:.4f} = {parts}"


def outward(bound: float, digits: int, *, up: bool) -> str:
    """Round a bound to ``digits`` decimals, towards the side on which it holds."""
    text, step = f"{bound:.{digits}f}", 10.0**-digits
    if up:
        return f"{bound + step:.{digits}f}" if float(text) < bound else text
    return f"{bound - step:.{digits}f}" if float(text) > bound else text
