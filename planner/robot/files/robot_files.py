"""Robot files, read once: robot.yaml, URDF and SRDF, with the choice of joints and tool."""

import importlib
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

import pinocchio as pin
import pydantic

from planner.base.errors import Note, RobotError, choices, require_extra
from planner.base.files import StrPath
from planner.base.resources import robot_names, robots_folder
from planner.base.yamlfile import Coordinate, Name, Number, Strict, parse_yaml, quote, read_text, validate
from planner.kinematics.arm import frame_id, tool_names
from planner.problem.options import Rows
from planner.problem.targets import HOME
from planner.robot.files import urdf
from planner.robot.files.packages import example_robot_data
from planner.robot.files.planar import Area, require_area
from planner.robot.files.srdf import Srdf, group_joints, group_tips, read_srdf

_ROBOT_FILE = "robot.yaml"
_DESCRIPTIONS = "robot_descriptions"  # a Python package; names of its robots end in _description


class Source(Strict):
    """A file next to the robot file, or in a Python package of robot data."""

    file: str
    package: Literal["example-robot-data"] | None = None
    args: dict[str, str] = pydantic.Field(default_factory=dict)  # of a xacro file

    def path(self, folder: Path) -> Path:
        return (example_robot_data() / "robots" if self.package else folder) / self.file


class MotionFile(Strict):
    """Acceleration and jerk limits: one number for all planned joints, or one per joint."""

    acceleration: Number | list[Number]  # rad/s², m/s² where a joint slides
    jerk: Number | list[Number] | None = None  # rad/s³, m/s³
    source: str  # origin of the numbers


class RobotFile(Strict):
    """Content of a ``robot.yaml``."""

    name: Name | None = None
    description: str = ""
    urdf: Source
    srdf: Source | None = None
    joints: list[str] | None = None
    tool: str | None = None
    home: list[Coordinate] | None = None
    manipulability: Rows | None = None
    fixed_joints: dict[str, Coordinate] = pydantic.Field(default_factory=dict)
    disabled_pairs: list[tuple[str, str]] | None = None
    mesh_pieces: bool = False
    motion: MotionFile | None = None
    base_limits: Annotated[tuple[Coordinate, ...], pydantic.AfterValidator(require_area)] | None = None


@dataclass(frozen=True)
class JointChoice:
    """The planned joints by name, or by SRDF group; else those of the robot file.

    Without either, the joints between base and tool frame.
    """

    group: str | None = None
    joints: tuple[str, ...] | None = None


ALL_JOINTS = JointChoice()


@dataclass(frozen=True, eq=False)
class RobotFiles:
    """A robot as its files describe it, before scene and request set it up."""

    name: str
    origin: str  # the name or path given by the user
    file: RobotFile  # for a URDF by path, it names that file only
    description: urdf.Description
    srdf: Srdf | None

    @cached_property
    def model(self) -> pin.Model:
        """Pinocchio's model of all movable joints."""
        return urdf.build_model(self.description)

    def select_joints(self, tool: str | None, choice: JointChoice, fixed: Mapping[str, float]) -> list[str]:
        """Return the planned joints, base first: the chosen ones that are not held.

        Raises :class:`RobotError` for unknown names, and for joints chosen by name that are held.
        """
        held = {**self.file.fixed_joints, **fixed}
        chosen = self._candidate_joints(self.tools(tool, choice), choice, held)
        if unknown := [name for name in chosen if not self.model.existJointName(name)]:
            raise RobotError(
                f"joint '{unknown[0]}' not found among the joints that move, {choices(self.model.names[1:])}: plan "
                "one of these."
            )
        if choice.joints is not None and (both := held.keys() & chosen):
            raise RobotError(
                f"joint '{min(both)}' is planned and held fixed as well: leave it out of --joints, or out of "
                "fixed_joints of the robot or scene file."
            )
        return [name for name in self.model.names[1:] if name in chosen and name not in held]

    def require_moved(self, planned: Sequence[str], tool: str) -> None:
        """Raise :class:`RobotError` unless one of the ``planned`` joints moves a tool."""
        between = self.leaders(tool)
        if not between:
            raise RobotError(f"no movable joint lies between the base and frame '{tool}': choose another tool frame.")
        if not {*planned} & {*between}:
            text = f"no joint that moves frame '{tool}' is planned: plan one of {choices(between)}"
            raise RobotError(f"{text}, or choose another tool frame.")

    def leaders(self, frame: str, held: Collection[str] = ()) -> list[str]:
        """Return the joints that move ``frame``, base first, leaders in place of followers.

        A joint in ``held`` follows no other.
        """
        joint = self.model.frames[frame_id(self.model, frame)].parentJoint
        joints = [self.model.names[k] for k in self.model.supports[joint] if k != 0]
        leaders = {self.description.mimic(joint, held).leader for joint in joints}
        return [joint for joint in self.model.names[1:] if joint in leaders]

    def _candidate_joints(self, tools: tuple[str, ...], choice: JointChoice, held: Collection[str]) -> list[str]:
        if choice.joints is not None:
            return list(choice.joints)
        if choice.group is not None:
            return self._group_joints(choice.group)
        if self.file.joints:
            return list(self.file.joints)
        passive = self.srdf.passive if self.srdf else frozenset()
        return [joint for joint in self._movers(tools, held) if joint not in passive]

    def _movers(self, tools: tuple[str, ...], held: Collection[str] = ()) -> list[str]:
        movers = {joint for tool in tools for joint in self.leaders(tool, held)}
        return [joint for joint in self.model.names[1:] if joint in movers]

    def tools(self, tool: str | None, choice: JointChoice) -> tuple[str, ...]:
        """Return the tool frames, which ``tool`` names with commas between, or the robot file.

        Those of a group are its tips, one for each group that it consists of, unless it moves all that are named.
        """
        requested, tool = tool, tool or self.file.tool
        named = () if tool is None else tool_names(tool)
        if choice.group is not None:
            joints = self._group_joints(choice.group)
            assert self.srdf is not None
            tips = group_tips(self.srdf, choice.group, self.description, joints)
            of_file = self.file.tool is not None and not requested
            several = len(tips) > 1 or len(named) > 1
            moved = all({*(joints if several else joints[-1:])} & {*self.leaders(each)} for each in named)
            if not named or not moved or (of_file and several):
                return tips
        if not named:
            tips = urdf.find_tips(self.model)
            likely = tips if len(tips) == 1 else urdf.guess_tools(self.model)[0]
            if len(likely) != 1:
                raise RobotError(f"the robot has {len(tips)} tips: name one as its tool; tips are {choices(tips)}.")
            return (likely[0],)
        for each in named:
            frame_id(self.model, each)
        return named

    def notes_on_tool(self, tool: str | None, choice: JointChoice) -> tuple[Note, ...]:
        """Return a note if the tool was guessed among several tips."""
        tips = urdf.find_tips(self.model)
        if tool or self.file.tool or choice.group is not None or len(tips) == 1:
            return ()
        (chosen,), why = self.tools(None, choice), urdf.guess_tools(self.model)[1]
        return (Note(f"Frame '{chosen}' is taken as the tool, {why}; tips are {choices(tips)}: --tool names another."),)

    def _group_joints(self, group: str) -> list[str]:
        if self.srdf is None:
            raise RobotError(f"robot '{self.name}' has no SRDF, so there are no groups: give --srdf, or use --joints.")
        return group_joints(self.srdf, group, self.description, self.model)

    @cached_property
    def home(self) -> Mapping[str, float]:
        """Joint values of the state home: from the robot file, else from the SRDF."""
        values_at_home: dict[str, float] = {}
        for state in sorted(self.srdf.states if self.srdf else (), key=lambda item: -len(item.values)):
            values_at_home |= state.values if state.name == HOME else {}
        values_at_home |= self._by_joint(self.file.home, "home") if self.file.home else {}
        return {joint: value for joint, value in values_at_home.items() if self.model.existJointName(joint)}

    def motion(self, planned: Sequence[str]) -> MotionFile | None:
        """Return motion limits with lists in the order of ``planned``; None if missing for any joint."""
        lists = dict[str, list[float]]()
        for kind in ("acceleration", "jerk"):
            if isinstance(values := getattr(self.file.motion, kind, None), list):
                of_joint = self._by_joint(values, kind)
                if not of_joint.keys() >= {*planned}:
                    return None
                lists[kind] = [of_joint[joint] for joint in planned]
        return self.file.motion and self.file.motion.model_copy(update=lists)

    def _by_joint(self, values: Sequence[float], what: str) -> dict[str, float]:
        """Return one value per joint that the robot file plans; :class:`RobotError` for other counts."""
        joints = self.file.joints or self._movers(self.tools(None, ALL_JOINTS))
        if len(joints) != len(values):
            raise RobotError(
                f"robot file {self.origin}: {what} has {len(values)} values, the robot {len(joints)} joints, "
                f"{choices(joints)}: give one value per joint."
            )
        return dict(zip(joints, values, strict=True))

    @cached_property
    def disabled_pairs(self) -> frozenset[frozenset[str]] | None:
        """Link pairs that SRDF and robot file exclude from checks; None if neither does."""
        # some SRDFs disable no pair
        disabled = self.srdf.pairs_without_check(self.description.links) if self.srdf else frozenset()
        listed = self.file.disabled_pairs
        if listed is None:
            return disabled or None
        if unknown := [link for pair in listed for link in pair if link not in self.description.links]:
            raise RobotError(
                f"robot file {self.origin}: disabled_pairs names link {quote(unknown[0])}, which the URDF lacks; "
                f"links are {choices(sorted(self.description.links))}."
            )
        return disabled | frozenset(frozenset(pair) for pair in listed)

    @property
    def notes(self) -> tuple[Note, ...]:
        """Notes on ignored content of the files."""
        of_srdf = self.srdf.notes(self.description, self.file.srdf is not None) if self.srdf else ()
        return (*self.description.notes, *of_srdf)


def read_robot(name: StrPath, srdf: StrPath | None = None, area: Area | None = None) -> RobotFiles:
    """Return the files of a robot given by name, path or URDF text; ``srdf`` replaces its own.

    So does the ``area`` of a base that moves in a plane. With one, the base moves by the planar joint of an SRDF, too.
    """
    name = os.fspath(name)
    text = name if name.lstrip().startswith("<") else None
    of_text = Path(), RobotFile(urdf=Source(file="<string>"), mesh_pieces=True)
    folder, file = find_robot(name) if text is None else of_text
    area = area or file.base_limits
    own = read_srdf(file.srdf.path(folder), file.srdf.args) if file.srdf and srdf is None else None
    own = read_srdf(Path(srdf)) if srdf is not None else own
    virtual = own.virtual if own and area else None
    description = urdf.read_description(file.urdf.path(folder), file.urdf.args, text, virtual, area)
    description = replace(description, pieces=file.mesh_pieces)
    name = name if text is None else "the text of a URDF"
    called = file.name or (name if name in robot_names() else description.name)
    return RobotFiles(called, name, file, description, own)


def robot_file(name: str) -> Path:
    """Return the robot.yaml or URDF that a name or path stands for, which may be missing."""
    if name in robot_names():
        return robots_folder() / name / _ROBOT_FILE
    return Path(name) / _ROBOT_FILE if name and os.path.isfile(Path(name) / _ROBOT_FILE) else Path(name)


def find_robot(name: str) -> tuple[Path, RobotFile]:
    """Return the folder of relative paths, and the robot file (for a URDF, one that names only it)."""
    path = robot_file(name)
    if path.suffix.lower() in (".yaml", ".yml"):
        where = f"robot file {path}"
        return path.parent, validate(RobotFile, parse_yaml(read_text(path, "robot file"), where), where, RobotError)
    if path.suffix.lower() in (".urdf", ".xml", ".xacro") or "/" in name:
        return Path(), RobotFile(urdf=Source(file=str(path)), mesh_pieces=True)
    if name.endswith("_description") and name.isidentifier() and not os.path.isfile(path):
        return Path(), _load_description_package(name)
    if os.path.isfile(path):
        raise RobotError(f"robot file {path} ends neither in .urdf nor in .yaml: rename it, or choose another file.")
    raise RobotError(
        f"robot '{name}' not found; robots are {choices(robot_names())}, or give the path of a URDF or of a robot.yaml "
        "('planner robot-yaml' writes one), or a name of robot_descriptions, as panda_description."
    )


def _load_description_package(name: str) -> RobotFile:
    """Return a robot of the package robot_descriptions, whose module may download its files."""
    require_extra(_DESCRIPTIONS, "descriptions")
    try:
        module = vars(importlib.import_module(f"{_DESCRIPTIONS}.{name}"))
        path = next(module[kind] for kind in ("URDF_PATH", "XACRO_PATH", "MJCF_PATH") if module.get(kind))
    except Exception as error:  # of a name that it lacks, of git, of the network
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise RobotError(
            f"robot '{name}' of robot_descriptions cannot be loaded ({reason}): choose another name."
        ) from None
    urdf_file = Source(file=str(path), args=module.get("XACRO_ARGS", {}) if path == module.get("XACRO_PATH") else {})
    srdf = module.get("SRDF_PATH") or module.get("SRDF_XACRO_PATH")
    srdf_file = Source(file=str(srdf), args=module.get("SRDF_XACRO_ARGS", {})) if srdf else None
    return RobotFile(name=name, urdf=urdf_file, srdf=srdf_file, mesh_pieces=True)
