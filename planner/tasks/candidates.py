"""The candidates of each step: grasps and placements with arm configurations, and the tool's lines."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from planner.base.arrays import Floats, Ints
from planner.base.errors import choices
from planner.base.yamlfile import suggest_name
from planner.kinematics.inverse import Tolerance, distinct_configurations, solve_within
from planner.kinematics.manipulability import manipulability
from planner.problem.request import TaskWorldRequest
from planner.problem.targets import parse_target
from planner.query.query import states_of
from planner.query.resolve import resolve
from planner.robot.robot import Robot
from planner.robot.scene import Scene
from planner.robot.shapes import Carried
from planner.tasks.modes import ARM, BLOCKED, VIOLATES, HeldObject, Mode, Modes
from planner.tasks.sampling import generate_grasps, make_placement, place_at, place_in_region, tool_poses
from planner.tasks.task import Gripper, Line, Move, Pick, Place, Task, TaskError

NO_OBJECT = -1  # number of the grasp and the placement of a move
STEP = 0.05  # m between two solutions of a line; the tool deviates from it by about STEP² / 8 / reach
RELEASE = 5e-3  # m of a line next to a rest, on which an object may touch its support
_JUMP = 0.5  # rad (m), largest distance of neighbouring solutions of a line
_APART = 1e-2  # rad, smallest distance of distinct solutions
_SEEDS = 2400  # of inverse kinematics, for all grasps or placements of a step
_FEWEST, _MOST = 12, 100  # seeds of each grasp or placement
_FEWEST_MORE = 2  # of a placement, besides the configurations of its grasp
_SEED = 0  # of random seeds: the solutions of a task do not depend on --seed
_GOALS = 8  # configurations of a goal


def solve_pose(robot: Robot, pose: Floats, seeds: Floats, most: int, tolerance: Tolerance) -> Floats:
    """Return at most ``most`` distinct configurations (k, dof) with the tool at ``pose``, best w first.

    See :func:`planner.kinematics.inverse.solve_within`; ``seeds`` (n, dof) are its initial values.
    """
    ends = _solve(robot, pose, seeds, tolerance)
    best = np.argsort(-manipulability(robot, ends), kind="stable") if len(ends) else slice(0)
    return distinct_configurations(robot, ends[best], _APART, most)


def follow_line(robot: Robot, q: Floats, poses: Floats, tolerance: Tolerance) -> Floats | None:
    """Return configurations (k + 1, dof) from ``q`` with the tool at ``poses`` (k, 4, 4); None for a jump."""
    path = [q]
    for pose in poses:
        ends = _solve(robot, pose, path[-1][None], tolerance)
        if not len(ends) or np.abs(robot.difference(path[-1], ends[0])).max() > _JUMP:
            return None
        path.append(path[-1] + robot.difference(path[-1], ends[0]))
    return np.array(path)


def _solve(robot: Robot, pose: Floats, seeds: Floats, tolerance: Tolerance) -> Floats:
    ends, _, _, solved = solve_within(robot, np.broadcast_to(pose, (len(seeds), 4, 4)), seeds, tolerance)
    return ends[solved]


def _line_poses(rest: Floats, line: Line, forward: bool, margin: float) -> Floats:
    """Return tool poses (k, 4, 4) from ``rest`` (4, 4): back on an approach, or ``forward`` on a retreat.

    The first pose is ``RELEASE`` plus ``margin`` (m) from the rest, or at the end of a shorter line; the others are at
    most ``STEP`` apart. A line of length 0 has one pose, the rest.
    """
    axis = np.array(line.axis) if line.frame == "world" else rest[:3, :3] @ np.array(line.axis)
    first = min(RELEASE + margin, line.distance)
    count = int(np.ceil((line.distance - first) / STEP - 1e-9))
    distances = np.append(first, first + (line.distance - first) * (np.arange(count) + 1) / max(count, 1))
    poses = np.tile(rest, (count + 1, 1, 1))
    poses[:, :3, 3] += np.outer(distances if forward else -distances, axis)
    return poses


@dataclass(frozen=True, eq=False)
class Candidate:
    """A configuration ``rest`` (dof,) of one grasp at one placement, with the tool's lines to and from it.

    The roadmap connects to both ``ends`` (2, dof). ``motions`` (3,) number the motions between its four corners: for a
    pick the start of the approach, the rest, ``RELEASE`` off it, and the end of the retreat; for a placement the start,
    ``RELEASE`` before the rest, the rest, and the end. A goal of a move has one corner and no motions; its grasp and
    placement are NO_OBJECT.
    """

    grasp: int
    place: int
    rest: Floats
    ends: Floats
    motions: Ints


@dataclass(eq=False)
class Rejected:
    """Number of grasps or placements tried for a step, and counts of the reasons of rejection."""

    of: int = 0
    violations: int = 0
    contacts: Counter[str] = field(default_factory=Counter)
    out_of_reach: list[Floats] = field(default_factory=list)  # requested tool positions (3,)

    def count_blocked(self, hits: Iterable[tuple[Candidate, str | None]]) -> None:
        """Count the first contact of each grasp at a placement whose candidates are all blocked; None is free."""
        groups: dict[tuple[int, int], list[str | None]] = {}
        for one, hit in hits:
            groups.setdefault((one.grasp, one.place), []).append(hit)
        for first, *others in groups.values():
            if first is not None and None not in others:
                self.violations += first == VIOLATES
                self.contacts.update({first} - {VIOLATES})


class Candidates:
    """The candidates of each step of a task that no fixed obstacle blocks.

    ``steps[k]`` are the candidates of a pick by placement, of a placement by grasp, of a move by ``NO_OBJECT``.
    ``first`` is the initial mode.
    """

    def __init__(self, task: Task, modes: Modes, gripper: Gripper, start: Floats, ik: TaskWorldRequest) -> None:
        """Find the candidates from ``start`` (1, dof); ``ik`` has the options of inverse kinematics."""
        self.task, self.modes, self.gripper, self.start, self._ik = task, modes, gripper, start, ik
        robot = modes.robot
        rng = np.random.default_rng(_SEED)
        self._seeds = np.vstack([start, robot.home, rng.uniform(robot.lower, robot.upper, (_MOST, robot.dof))])
        self.steps: list[dict[int, list[Candidate]]] = []
        self.rejected: list[Rejected] = []
        self._held = list(range(len(modes.grasps)))  # remaining grasps of the held object
        self._seeds_of: dict[int, list[Floats]] = {}  # configurations of each grasp
        stands = [item for name, item in modes.objects.items() if name not in {held.object for held in modes.grasps}]
        for item in stands:
            others = tuple(other for other in stands if other is not item)
            modes.placements.append(make_placement(item, item.placement, modes.checker, others))
        self._standing = {each.object: [k] for k, each in enumerate(modes.placements)}  # placements by object
        self.first = Mode(tuple(range(len(modes.placements))), self._held[0] if self._held else None)
        for step in task.steps:
            self.rejected.append(Rejected())
            match step:
                case Move():
                    self.steps.append({NO_OBJECT: self._goals(len(self.rejected), step)})
                case Pick():
                    self.steps.append(self._pick(step))
                case Place():
                    self.steps.append(self._place(step))

    @property
    def dead_end(self) -> int | None:
        """The first step (from 0) without candidates."""
        return next((k for k, step in enumerate(self.steps) if not any(step.values())), None)

    def _goals(self, number: int, step: Move) -> list[Candidate]:
        checker, role, none = self.modes.checker, f"step {number}, the move,", np.zeros(0, dtype=np.int64)
        states = states_of(checker.robot, checker.world.scene)
        goals = resolve(parse_target(step.to), checker, states, role, _GOALS, self.start, self._ik.ik_tolerance)
        return [Candidate(NO_OBJECT, NO_OBJECT, q, np.array([q, q]), none) for q in goals]

    def _pick(self, step: Pick) -> dict[int, list[Candidate]]:
        item, first = self.modes.objects[step.object], len(self.modes.grasps)
        if step.grasps is None:
            self.modes.grasps += generate_grasps(item.name, item.shape, self.gripper.opening)
        else:
            given = [HeldObject(item.name, tool, grasp.opening) for grasp in step.grasps for tool in tool_poses(grasp)]
            widest, opens = max(grasp.opening or 0.0 for grasp in given), self.gripper.opening
            if opens is not None and widest > opens + 1e-9:
                raise TaskError(f"a grasp of '{item.name}' must open at most {opens:g} m, got {widest:g}: narrow it.")
            self.modes.grasps += given
        numbers = range(first, len(self.modes.grasps))
        by_place = {at: self._candidates(step, [(g, at) for g in numbers], {}) for at in self._standing[item.name]}
        every = [one for candidates in by_place.values() for one in candidates]
        self._held = [g for g in numbers if any(one.grasp == g for one in every)]
        self._seeds_of = {g: [one.rest for one in every if one.grasp == g] for g in self._held}
        return by_place

    def _place(self, step: Place) -> dict[int, list[Candidate]]:
        item, among, first = self.modes.objects[step.object], self.modes.checker, len(self.modes.placements)
        if step.on is not None:
            self.modes.placements += place_in_region(item, step, among.world.obstacles, among.world.margin)
        else:
            self.modes.placements += [place_at(item, each, among) for each in step.pose]
        numbers = self._standing[item.name] = list(range(first, len(self.modes.placements)))
        candidates = self._candidates(step, [(g, p) for g in self._held for p in numbers], self._seeds_of)
        return {g: [one for one in candidates if one.grasp == g] for g in self._held}

    def _candidates(self, step: Pick | Place, pairs: Sequence[tuple[int, int]], seeds: dict) -> list[Candidate]:
        rejected, candidates, share = self.rejected[-1], [], _SEEDS // max(len(pairs), 1)
        for number, (grasp, place) in enumerate(pairs):
            self.modes.progress("grasps", number, len(pairs))
            rejected.of += 1
            tool = self.modes.placements[place].pose @ self.modes.grasps[grasp].tool
            many = min(max(share, _FEWEST_MORE if grasp in seeds else _FEWEST), _MOST)
            near = np.vstack([*seeds.get(grasp, ()), *self._seeds[:many]])
            reachable = self._reach(step, grasp, place, tool, near)
            if not reachable:
                rejected.out_of_reach.append(tool[:3, 3])
            candidates += reachable
        self.modes.progress("grasps", len(pairs), len(pairs))
        return self._remove_blocked(step, candidates)

    def _reach(self, step: Pick | Place, grasp: int, place: int, tool: Floats, seeds: Floats) -> list[Candidate]:
        """Return the candidates that reach one pose of the tool, with feasible lines."""
        margin = self.modes.checker.world.margin
        out, away = (_line_poses(tool, *line, margin) for line in ((step.approach, False), (step.retreat, True)))
        add, robot, candidates = self.modes.motions.add_path, self.modes.robot, []
        most, tolerance = self._ik.ik_solutions, self._ik.ik_tolerance
        most = most if isinstance(step, Pick) else max(1, most // 2)  # there are many pairs of placement and grasp
        for q in solve_pose(robot, tool, seeds, most, tolerance):
            before, after = (follow_line(robot, q, poses, tolerance) for poses in (out, away))
            if before is None or after is None:
                continue
            before, ends = before[::-1], np.array([before[-1], after[-1]])
            lines = (before, after[:2], after[1:]) if isinstance(step, Pick) else (before[:-1], before[-2:], after)
            candidates.append(Candidate(grasp, place, q, ends, np.array([add(line) for line in lines])))
        return candidates

    def _remove_blocked(self, step: Pick | Place, candidates: list[Candidate]) -> list[Candidate]:
        """Return the candidates whose lines are free of fixed obstacles, and of the object for the empty hand."""
        if not candidates:
            return candidates
        modes, empty = self.modes, 0 if isinstance(step, Pick) else 2
        motions, places = np.array([one.motions for one in candidates]), np.array([one.place for one in candidates])
        modes.prove(ARM, motions.ravel())
        is_open = (modes.verdicts_of(ARM)[motions] != BLOCKED).all(axis=1)
        for place in np.unique(places).tolist():
            modes.prove(self._at_object(place), motions[(places == place) & is_open, empty])
        hits = []
        for one in candidates:
            keys = [(ARM, motion) for motion in one.motions.tolist()]
            keys.insert(empty + 1, (self._at_object(one.place), keys[empty][1]))
            hits.append(next((modes.blame[key] for key in keys if key in modes.blame), None))
        self.rejected[-1].count_blocked(zip(candidates, hits, strict=True))
        return [one for one, hit in zip(candidates, hits, strict=True) if hit is None]

    def _at_object(self, place: int) -> Mode:
        """Return the mode of the empty hand next to an object, which the gripper's links may touch."""
        return Mode((place,)).allow(*self.at_hand(place))

    def at_hand(self, place: int) -> list[tuple[str, str]]:
        """Return pairs of the gripper's links and an object."""
        return [(link, self.modes.placements[place].object) for link in self.gripper.touch or ()]

    def at_rest(self, place: int) -> list[tuple[str, str]]:
        """Return pairs of an object and its supports."""
        return [(self.modes.placements[place].object, on) for on in self.modes.placements[place].supports]


def require_sensible(task: Task, scene: Scene) -> Carried | None:
    """Raise :class:`TaskError` for missing objects and wrong order of steps.

    Returns the object that the arm carries in the scene, if the first step places it.
    """
    names = [item.object for item in scene.obstacles]
    handled = next((step for step in task.steps if not isinstance(step, Move)), None)
    placed = handled.object if isinstance(handled, Place) else None
    first = next((item for item in scene.carried if item.name == placed), None)
    held = None if first is None else first.name
    for k, step in enumerate(task.steps, start=1):
        if isinstance(step, Pick):
            picks = f"step {k} picks '{step.object}'"
            if step.object not in names:
                meant, there = suggest_name(step.object, names), choices(names)
                raise TaskError(f"{picks}{meant}, not found in the scene; obstacles are {there}.")
            if names.count(step.object) > 1:
                raise TaskError(f"{picks}, which must be one shape, got several: name one shape.")
            if held is not None:
                raise TaskError(f"{picks} while '{held}' is held: place that first.")
            held = step.object
        elif isinstance(step, Place):
            if held != step.object:
                what = f"'{held}' is held" if held else "nothing is held"
                raise TaskError(f"step {k} places '{step.object}', but {what}: pick it first.")
            names += [] if step.object in names else [step.object]
            held = None
    return first
