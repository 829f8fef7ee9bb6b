"""Every way to do a step: grasps and placements with the configurations that reach them, and the lines to and fro."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import choices
from planner.base.yamlfile import nearest
from planner.collision import coal_checker
from planner.collision.world import World
from planner.kinematics.forward import tool_joint, tool_pose
from planner.problem.request import TaskWorldRequest
from planner.problem.targets import parse_target
from planner.query.query import states_of
from planner.query.resolve import resolve
from planner.robot.scene import Scene
from planner.robot.shapes import Carried, Obstacle
from planner.tasks.file import Grasp, Move, Pick, Region, Task, TaskError
from planner.tasks.file import Place as PlaceStep
from planner.tasks.grasps import generated
from planner.tasks.gripper import Gripper
from planner.tasks.modes import ARM, BLOCKED, STRAYS, Held, Mode, Modes, Place
from planner.tasks.placements import REST, at_pose, extent, in_region, standing
from planner.tasks.reach import along, line_poses, solutions

NOTHING = -1  # in the place of a number of a grasp or a place
_SEEDS = 2400  # of inverse kinematics for a step, shared by its grasps or placements
_FEWEST, _MOST = 12, 100  # for each
_FEWEST_BESIDE = 2  # for each placement, beside the configurations of its grasp
_SEED = 0  # of these: the same task has the same solutions, whatever --seed says
_GOALS = 8  # configurations that a state becomes at most


@dataclass(frozen=True, eq=False)
class Option:
    """One configuration ``rest`` (dof,) of one grasp at one place, with the lines of the tool to it and off it.

    It is joined to the roadmap at both ``ends`` (2, dof). ``motions`` (3,) are numbers of what leads from corner to
    corner. The corners of a pick are the begin of its approach, the rest, ``RELEASE`` off it, and the end of its
    retreat; of a placement the begin, ``RELEASE`` before the rest, the rest, and the end. A goal of a move is one
    corner: it has no motions, its grasp and place are NOTHING.
    """

    grasp: int
    place: int
    rest: Floats
    ends: Floats
    motions: Ints


@dataclass(eq=False)
class Tried:
    """Of how many grasps or placements of a step a configuration was sought, and what became of the others."""

    of: int = 0
    strays: int = 0
    contacts: Counter[str] = field(default_factory=Counter)
    out_of_reach: list[Floats] = field(default_factory=list)  # where the tool was to be (3,)

    def count_blocked(self, hits: Iterable[tuple[Option, str | None]]) -> None:
        """Count each grasp at a place all options of which are blocked, by what the first touches; None: it is not."""
        groups: dict[tuple[int, int], list[str | None]] = {}
        for option, hit in hits:
            groups.setdefault((option.grasp, option.place), []).append(hit)
        for found in groups.values():
            first = found[0]
            if first is not None and None not in found:
                self.strays += first == STRAYS
                self.contacts.update({first} - {STRAYS})


class Options:
    """What each step of a task can choose from, as far as it is not blocked by what all modes share.

    ``steps[k]`` are the options of a pick by place, of a placement by grasp, of a move all by
    ``NOTHING``. ``first`` is the mode of the beginning.
    """

    def __init__(self, task: Task, modes: Modes, gripper: Gripper, start: Floats, ik: TaskWorldRequest) -> None:
        """``start`` (1, dof); ``ik`` configurations of each grasp. What is held by now has a grasp."""
        self.task, self.modes, self.gripper, self.start, self._ik = task, modes, gripper, start, ik
        robot = modes.robot
        rng = np.random.default_rng(_SEED)
        self._seeds = np.vstack([start, robot.home, rng.uniform(robot.lower, robot.upper, (_MOST, robot.dof))])
        self.steps: list[dict[int, list[Option]]] = []
        self.tried: list[Tried] = []
        self.stands = {place.object: [self._new_place(place)] for place in _initial(modes)}
        self._held = list(range(len(modes.grasps)))  # grasps that are left, of the object that is held
        self._seeds_of: dict[int, list[Floats]] = {}  # configurations that hold it, by grasp
        self._require_free_tops()
        numbers = tuple(sorted(places[0] for places in self.stands.values()))
        self.first = Mode(numbers, self._held[0] if self._held else None)
        for step in task.steps:
            self.tried.append(Tried())
            match step:
                case Move():
                    self.steps.append({NOTHING: self._goals(len(self.tried), step)})
                case Pick():
                    self.steps.append(self._pick(step))
                case PlaceStep():
                    self.steps.append(self._place(step))

    @property
    def dead_end(self) -> int | None:
        """The first step (from 0) that nothing is left for."""
        return next((k for k, step in enumerate(self.steps) if not any(step.values())), None)

    def _require_free_tops(self) -> None:
        """Raise :class:`TaskError` where something is picked on which another stands that is picked later."""
        first = {name: self.modes.places[places[0]] for name, places in self.stands.items()}
        for number, step in enumerate(self.task.steps, start=1):
            below = first.pop(step.object, None) if isinstance(step, Pick) else None
            if below is None:
                continue
            for name, place in first.items():
                beside = self._heights(place)[0] < self._heights(below)[1] - REST  # they touch side by side
                if below.object in place.supports and not beside:
                    raise TaskError(
                        f"step {number} picks '{below.object}' while '{name}' stands on it: pick '{name}' before."
                    )

    def _heights(self, place: Place) -> Floats:
        """How low and how high (2,) m an object at a place reaches."""
        ends = extent(self.modes.objects[place.object].shape, place.pose[:3, :3])
        return np.array(ends)[:, 2] + place.pose[2, 3]

    def _new_place(self, place: Place) -> int:
        self.modes.places.append(place)
        return len(self.modes.places) - 1

    def _goals(self, number: int, step: Move) -> list[Option]:
        checker, role, none = self.modes.checker, f"step {number}, the move,", np.zeros(0, dtype=np.int64)
        states = states_of(checker.robot, checker.world.scene)
        found = resolve(parse_target(step.to), checker, states, role, _GOALS, self.start, self._ik.ik_tolerance)
        return [Option(NOTHING, NOTHING, q, np.array([q, q]), none) for q in found]

    def _pick(self, step: Pick) -> dict[int, list[Option]]:
        item, first = self.modes.objects[step.object], len(self.modes.grasps)
        given = generated(item.name, item.shape, self.gripper.opening) if step.grasps is None else step.grasps
        if step.grasps is not None:
            if all(_hand_in(item, grasp, self.modes, self.gripper) for grasp in given):
                raise TaskError(
                    f"every grasp of '{item.name}' has the hand inside it: give tool poses in the object's frame, in "
                    f"metres, with no link but {choices(self.gripper.touch)} at the object."
                )
            widest = max(grasp.opening or 0.0 for grasp in given)
            if self.gripper.opening is not None and widest > self.gripper.opening + 1e-9:
                raise TaskError(
                    f"a grasp of '{item.name}' opens the gripper {widest:g} m wide, which opens "
                    f"{self.gripper.opening:g} m: give a narrower one, or the gripper's 'opening'."
                )
        self.modes.grasps += [Held(item.name, grasp) for grasp in given]
        numbers = range(first, len(self.modes.grasps))
        found = {place: self._options(step, [(g, place) for g in numbers], {}) for place in self.stands[item.name]}
        every = [option for options in found.values() for option in options]
        self._held = [g for g in numbers if any(option.grasp == g for option in every)]
        self._seeds_of = {g: [o.rest for o in every if o.grasp == g] for g in self._held}
        return found

    def _place(self, step: PlaceStep) -> dict[int, list[Option]]:
        item, among = self.modes.objects[step.object], self.modes.checker
        if isinstance(step.at, Region):
            places = in_region(item, step.at, among.world.obstacles, among.world.margin)
        else:
            places = [at_pose(item, placement, among) for placement in step.at]
        numbers = self.stands[item.name] = [self._new_place(place) for place in places]
        options = self._options(step, [(g, p) for g in self._held for p in numbers], self._seeds_of)
        return {g: [option for option in options if option.grasp == g] for g in self._held}

    def _options(self, step: Pick | PlaceStep, pairs: Sequence[tuple[int, int]], seeds: dict) -> list[Option]:
        tried, found, share = self.tried[-1], [], _SEEDS // max(len(pairs), 1)
        for grasp, place in pairs:
            tried.of += 1
            tool = self.modes.places[place].pose @ self.modes.grasps[grasp].grasp.pose
            many = min(max(share, _FEWEST_BESIDE if grasp in seeds else _FEWEST), _MOST)
            near = np.vstack([*seeds.get(grasp, ()), *self._seeds[:many]])
            options = self._at(step, grasp, place, tool, near)
            if not options:
                tried.out_of_reach.append(tool[:3, 3])
            found += options
        return self._unblocked(step, found)

    def _at(self, step: Pick | PlaceStep, grasp: int, place: int, tool: Floats, seeds: Floats) -> list[Option]:
        """The options that reach one pose of the tool, whose lines can be followed."""
        margin = self.modes.checker.world.margin
        out, away = (line_poses(tool, *line, margin) for line in ((step.approach, False), (step.retreat, True)))
        add, robot, found = self.modes.motions.through, self.modes.robot, []
        most, tolerance = self._ik.ik_solutions, self._ik.ik_tolerance
        most = most if isinstance(step, Pick) else max(1, most // 2)  # of a placement there are many
        for q in solutions(robot, tool, seeds, most, tolerance):
            before, after = (along(robot, q, poses, tolerance) for poses in (out, away))
            if before is None or after is None:
                continue
            before, ends = before[::-1], np.array([before[-1], after[-1]])
            parts = (before, after[:2], after[1:]) if isinstance(step, Pick) else (before[:-1], before[-2:], after)
            found.append(Option(grasp, place, q, ends, np.array([add(part) for part in parts])))
        return found

    def _unblocked(self, step: Pick | PlaceStep, options: list[Option]) -> list[Option]:
        """Those whose lines the arm can follow among what is fixed, and the empty hand beside the object itself."""
        if not options:
            return options
        modes, empty = self.modes, 0 if isinstance(step, Pick) else 2
        motions, places = np.array([o.motions for o in options]), np.array([o.place for o in options])
        modes.prove(ARM, motions.ravel())
        open_ = (modes.known(ARM)[motions] != BLOCKED).all(axis=1)
        for place in np.unique(places).tolist():
            modes.prove(self.beside(place), motions[(places == place) & open_, empty])
        hits = []
        for option in options:
            parts = [(ARM, m) for m in option.motions.tolist()]
            parts.insert(empty + 1, (self.beside(option.place), parts[empty][1]))
            hits.append(next((modes.blame[part] for part in parts if part in modes.blame), None))
        self.tried[-1].count_blocked(zip(options, hits, strict=True))
        return [option for option, hit in zip(options, hits, strict=True) if hit is None]

    def beside(self, place: int) -> Mode:
        """The hand going to, or coming from, an object at a place: of it the gripper's links may touch it."""
        return Mode((place,)).allowing(*self.at_hand(place))

    def at_hand(self, place: int) -> list[tuple[str, str]]:
        return [(link, self.modes.places[place].object) for link in self.gripper.touch]

    def at_rest(self, place: int) -> list[tuple[str, str]]:
        """An object and what it stands on."""
        return [(self.modes.places[place].object, on) for on in self.modes.places[place].supports]


def _hand_in(item: Obstacle, grasp: Grasp, modes: Modes, gripper: Gripper) -> bool:
    """Whether links that the tool's joint carries, but for those that may, touch an object in a grasp."""
    robot, (last, _) = modes.robot, tool_joint(modes.robot)
    held = replace(item, placement=tool_pose(robot, robot.home).homogeneous @ np.linalg.inv(grasp.pose))
    scene = replace(modes.checker.world.scene, obstacles=(held,), allowed=frozenset())
    checker = coal_checker(World.of(robot, scene, frozenset()))
    bodies = [k for k, b in enumerate(robot.bodies) if b.joint == last and b.link not in gripper.touch]
    return bool((checker.gaps(robot.home, np.array(bodies, dtype=np.int64)) <= 0).any())


def _initial(modes: Modes) -> Iterator[Place]:
    """Where the objects stand at the beginning; on what they rest is found among all that stands."""
    held = {item.object for item in modes.grasps}
    objects = [item for name, item in modes.objects.items() if name not in held]
    for item in objects:
        yield standing(item, item.placement, modes.checker, tuple(other for other in objects if other is not item))


def require_sensible(task: Task, scene: Scene) -> Carried | None:
    """Raise :class:`TaskError` for objects that are not there, or not one thing, and for steps out of order.

    Returns what the scene lets the arm carry, if that is what the task places first.
    """
    names = [item.object for item in scene.obstacles]
    handled = next((step for step in task.steps if not isinstance(step, Move)), None)
    placed = handled.object if isinstance(handled, PlaceStep) else None
    first = next((item for item in scene.carried if item.name == placed), None)
    held = None if first is None else first.name
    for k, step in enumerate(task.steps, start=1):
        if isinstance(step, Pick):
            _require_object(step.object, names, k)
            if held is not None:
                raise TaskError(f"step {k} picks '{step.object}' while '{held}' is held: place that first.")
            held = step.object
        elif isinstance(step, PlaceStep):
            if held != step.object:
                what = f"'{held}' is held" if held else "nothing is held"
                raise TaskError(f"step {k} places '{step.object}', but {what}: pick it first.")
            if step.object not in names:
                names.append(step.object)
            held = None
    return first


def _require_object(name: str, names: list[str], step: int) -> None:
    if names.count(name) > 1:
        raise TaskError(f"'{name}', which step {step} picks, is made of several shapes: give one that is one shape.")
    if name not in names:
        raise TaskError(
            f"step {step} picks '{name}'{nearest(name, names)}, which is not in the scene; its obstacles are "
            f"{choices(names)}."
        )
