"""What plans, trade-offs and tasks have in common: a record, which their JSON file is, a table, a page and files."""

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
    "seconds per stage, and their `total` with all between, to the last file; `record` measures the path for this file "
    "and encloses when the field settles, `files` writes the others"
)
_CORNERS = ("corners", "corners_blended", "shortcuts")  # keys of a trajectory's proof


@dataclass(frozen=True, kw_only=True, eq=False)
class RunRecord(Record):
    """How a run ended, what it was asked for, and with which software."""

    # pydantic reads docstrings of a class's own fields only, and other records begin with these
    format_version: int
    outcome: Annotated[str, Field(description="solved, no_path, too_singular, partly_followed or interrupted")]
    message: Annotated[str, Field(description="the outcome as a sentence, with its reason and the remedy")]
    robot: str
    scene: str
    seed: int
    config: Annotated[dict[str, Any], Field(description="every option")]
    versions: Annotated[dict[str, str], Field(description="of the planner, Python and its libraries")]
    joints: Annotated[list[str], Field(description="the planned ones, in the order of the columns of a path")]
    tool: str
    notes: Annotated[list[str], Field(description="what was noticed about the model and the start")]
    timings_s: Annotated[dict[str, float], Field(description=_SECONDS)]

    @classmethod
    def from_run(cls, run: Result[Any], robot: Robot, scene: Scene, **own: Any) -> Self:
        """The record of a run of ``robot`` in ``scene``, with the fields that this class adds."""
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
            tool=robot.tool,
            notes=[*(note.text for note in notes(robot, scene)), *run.end_notes],
            timings_s=round_seconds(run.timings),
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
    """The record in a JSON file; :class:`FileError` where it is missing, damaged or of a later format."""
    where = f"plan {file}"
    data = parse_json(read_text(file, "plan"), where)
    if isinstance(data, dict):
        require_readable_version(data, where)
    return validate(kind, data, where)


@dataclass(frozen=True, eq=False)
class Result(ABC, Generic[R]):
    """Base of what a command finds: it shows itself as a table and as a page, and saves itself in a folder.

    ``reason`` says why there is no path, ``end_notes`` what was noticed about the start; ``timings`` are in s.
    """

    JSON: ClassVar[str] = JSON_NAME
    PAGE: ClassVar[str] = PAGE_NAME
    FILES: ClassVar[tuple[str, ...]]  # all that are written, in the order in which they take their places

    request: Request
    outcome: Outcome
    reason: Reason | None = field(default=None, kw_only=True)
    end_notes: tuple[str, ...] = field(default=(), kw_only=True)
    timings: dict[str, float] = field(default_factory=dict, kw_only=True)

    @cached_property
    @abstractmethod
    def record(self) -> R:
        """What the JSON file holds; units in rad, m and s."""

    @abstractmethod
    def page(self) -> str:
        """The page as HTML text that needs nothing but a browser."""

    @abstractmethod
    def _write(self, folder: Path) -> None:
        """Write the files but for page, proof and record into an empty folder."""

    def files(self, folder: Path) -> Sequence[str]:
        """The files that take their places in ``folder``, in this order; one that is not written is removed."""
        return self.FILES

    def certify(self) -> Certificate | None:
        """The result with its proof, for a checker that trusts no planner; None where there is none."""
        return None

    @property
    def message(self) -> str:
        """How the run ended, in one sentence: without a path the reason, as far as it is known."""
        return self.outcome.value if self.reason is None else self.reason.sentence

    @property
    def solved(self) -> bool:
        """Whether there is a path."""
        return self.outcome is Outcome.SOLVED

    @property
    def seconds(self) -> float:
        """How long it took, all stages together."""
        return sum(self.timings.values())

    def to_dict(self) -> dict[str, Any]:
        """The keys of the JSON file."""
        return self.record.to_dict()

    def _repr_html_(self) -> str:
        record = self.record
        return html_table(f"{record.robot} in {record.scene}. {record.message}", record.summary)

    def save(self, folder: StrPath, certificate: bool = False) -> None:
        """Write the files into ``folder``, which is made if it does not exist, with the page.

        With ``certificate`` also ``proof.npz`` where there is a proof. Raises :class:`FileError` where that cannot be
        done.
        """
        clock = Stopwatch(self.timings)
        self.save_page(Path(folder), self.save_without_page(Path(folder), clock, certificate), clock)

    def save_without_page(self, folder: Path, clock: Stopwatch | None = None, certificate: bool = False) -> R:
        """Write all but the page, remove what an earlier run left, and return the record, which is renamed last.

        The stages of ``clock`` go into the record with the run's own.
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
        """Write the page, and the record again with the seconds of ``clock``; returns that record."""
        with clock("page"):
            write_whole(folder / self.PAGE, self.page().encode())
        record = replace(record, timings_s=clock.record())
        write_json(folder / self.JSON, record.to_dict())
        return record


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionRecord(Record):
    """The motion along the path, which trajectory.json holds."""

    time_law: str
    duration: float
    """s"""
    limits: str
    corners: int | None = None
    corners_blended: int | None = None
    shortcuts: int | None = None
    proven: bool
    """whether every piece is proven free and within limits"""
    floor: dict[str, Any] | None
    """``proof.floor`` of trajectory.json"""

    @classmethod
    def from_trajectory(cls, made: Trajectory | None, robot: Robot) -> Self | None:
        if made is None:
            return None
        limits = "" if made.limits is None else made.limits.text(robot)
        known = {key: made.proof[key] for key in _CORNERS if key in made.proof}
        known |= {"proven": made.proven, "floor": made.proof.get("floor")}
        return cls(time_law=made.time_law, duration=made.duration, limits=limits, **known)

    def text(self, floored: bool) -> str:
        """The motion as a line of a table, with its floor where that was asked for."""
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
    """How the dynamics settled."""

    law: str
    prescribed_time: float
    """T_p, s"""
    settling_time: float | None
    """s"""
    settling_tau: float | None
    settling_tau_bracket: list[float | None] | None
    """proved: earliest and latest, null where it was not found; 0 and null for a field too large to be enclosed"""
    log10_remaining: float | None
    """log10 of T_p minus the settling time"""
    steps: int
    residual: float | None
    max_error_vs_oracle: float | None
    """relative, against Dijkstra's answer"""
    outcome: str
    certificate: list[dict[str, Any]]
    """the bounds of the paper, and ours, beside the measured values, as :class:`planner.gabf.Certificate` has them"""

    @classmethod
    def from_field(cls, quality: SweepQuality | TaskQuality, field: gabf.CostToGo | None) -> Self | None:
        """The record of a field, with every bound that it meets and its error against the oracle."""
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
        """When the field settled, the sharpest proven bound on that, and the error against the oracle."""
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
    """A path's cost and the two parts that it is the sum of."""
    beta = cost.beta
    parts = f"{1 - beta:g} x {cost.manipulability:.4f} manipulability + {beta:g} x {cost.distance:.4f} distance"
    return f"{cost.total:.4f} = {parts}"


def outward(bound: float, digits: int, *, up: bool) -> str:
    """A bound with so many digits behind the point, rounded to the side on which it holds."""
    text, step = f"{bound:.{digits}f}", 10.0**-digits
    if up:
        return f"{bound + step:.{digits}f}" if float(text) < bound else text
    return f"{bound - step:.{digits}f}" if float(text) > bound else text
