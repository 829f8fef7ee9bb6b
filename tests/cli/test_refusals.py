"""Every command refuses bad options (2) and bad files (3) with one sentence, and writes nothing."""

from pathlib import Path

import pytest

from tests.command_line import Run, assert_refused, assert_remedies_are_options
from tests.documents import ROOT

BEYOND = "q:0,2.5,0,-1,0,1,0"
SEAM = f"follow {ROOT}/scenes/examples/seam.yaml --robot panda --scene table"
ARM = f"{ROOT}/robots/examples/arm.urdf --tool tip"
TASK = "robot: iiwa14\nscene: empty\nsteps: [{move: there}]\n"
BALL = "obstacles:\n  - {name: a, type: sphere, radius: RADIUS}\n"
AXIS = "axis: [0, 0, 1]"
_PRONG = (
    '<link name="{0}"/><joint name="j{0}" type="revolute"><parent link="base"/><child link="{0}"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
)
FILES = {
    "file": "precious",
    "three.csv": "1,2,3\n",
    "two.csv": "1,2\n1,2.1\n",
    "page.html": "<html>",
    "broken.yaml": "obstacles: [",
    "key.yaml": "obstacels: []",
    "list.yaml": "- 1\n- 2",
    "box.yaml": "obstacles: [{name: a, type: box, size: [0.1, 0, 0.1]}]",
    "cone.yaml": "obstacles: [{name: a, type: cone, radius: 1}]",
    "nan.yaml": BALL.replace("RADIUS", ".nan"),
    "rotations.yaml": BALL.replace("RADIUS", "1, rpy: [0, 0, 0], quaternion: [0, 0, 0, 1]"),
    "zero.yaml": BALL.replace("RADIUS", "1, quaternion: [0, 0, 0, 0]"),
    "twice.yaml": (BALL + "  - {name: a, type: sphere, radius: 1}\n").replace("RADIUS", "1"),
    "mesh.yaml": "obstacles: [{name: a, type: mesh, file: none.stl}]",
    "object.yaml": "obstacles: !!python/object/apply:os.system ['touch owned']",
    "lump.yaml": "obstacles: [{name: lump, type: sphere, radius: 0.2, position: [0, 0, 1.2]}]\n"
    "states:\n  iiwa14: {start: 'q:0,0,0,0,0,0,0', goal: 'q:0,1,0,0,0,0,0'}\n",
    "line.yaml": "points:\n  - {position: [0.5, 0, 0.5], axis: [0, 0, -1]}\n"
    "  - {position: [0.5, 0.1, 0.5], axis: [0, 0, -1]}\n",
    "no-points.yaml": "points: []",
    "nan-point.yaml": f"points: [{{position: [.nan, 0, 0], {AXIS}}}]",
    "mm.yaml": f"points: [{{position: [400, 0, 0], {AXIS}}}, {{position: [0, 0, 1], {AXIS}}}]",
    "tube.yaml": f"{{points: [{{position: [0.4, 0, 0.3], {AXIS}}}], tube: {{position: 0}}}}",
    "start.yaml": TASK + f"start: '{BEYOND}'\n",
    "move.yaml": TASK.replace("there", f"'{BEYOND}'"),
    "state.yaml": TASK.replace("empty", "scene.yaml"),
    "scene.yaml": "obstacles: []\nstates:\n  iiwa14: {there: gone}\n",
    "forked.yaml": TASK.replace("iiwa14", "fork.urdf"),
    "fork.urdf": f'<robot name="fork"><link name="base"/>{_PRONG.format("left")}{_PRONG.format("right")}</robot>',
    "mug.yaml": TASK.replace("move: there", "pick: mug"),
}

FORMS = "a name from the scene, q:..., xyz:x,y,z, pose:x,y,z,qx,qy,qz,qw or conditions such as axis:z,0,0,-1,0.1"
IIWA = (
    "planned joints of iiwa14 are iiwa14_joint_1, iiwa14_joint_2, iiwa14_joint_3, iiwa14_joint_4, "
    "iiwa14_joint_5, iiwa14_joint_6, iiwa14_joint_7"
)
ROBOTS = (
    "robots are iiwa14, kinova, panda, planar_2r, so101, ur10, ur5, xarm7, z1, or give the path of a URDF "
    "or of a robot.yaml ('planner robot-yaml' writes one), or a name of robot_descriptions, as "
    "panda_description"
)
OUTSIDE = "puts joint 'iiwa14_joint_2' at 2.5, outside its limits [-2.0944, 2.0944] by 0.406 rad: bring it inside"

# each command, its exit code and the whole sentence
ROWS = [
    ("plan --robot r2d2", 3, f"robot 'r2d2' not found; {ROBOTS}."),
    ("plan --robot nowhere/arm.urdf", 3, "URDF nowhere/arm.urdf not found: check the path."),
    (
        "plan --scene moon",
        3,
        "scene 'moon' not found; scenes are cage, empty, paper, shelf, table, window, gcs, or give the "
        "path of a scene file.",
    ),
    (
        "plan --goal xyz:1e200,0,0",
        3,
        "goal must hold finite numbers of at most 10000, got 1e+200: give them in rad and metres.",
    ),
    (
        "plan --goal xyz:3,0,0.5",
        3,
        "goal (3, 0, 0.5) cannot be reached by frame 'flange': the nearest configuration of 100 tries "
        "stays 2.06 m away (the target lies 2.06 m beyond the arm's reach); choose a nearer one.",
    ),
    (
        "plan --goal home --goal nowhere",
        3,
        f"goal 'nowhere' not found; states of iiwa14 in the scene are start, goal, home: give one of them, or {FORMS}.",
    ),
    (
        "plan --goal pose:0.4,0,0.6,0,0,0,0",
        3,
        "goal: quaternion must not be zero, got [0, 0, 0, 0]; [0, 0, 0, 1] is the identity; give a unit "
        "quaternion qx,qy,qz,qw.",
    ),
    (
        "plan --tool tol0",
        3,
        "frame 'tol0' not found; frames are universe, iiwa14_link_0, iiwa14_joint_1, iiwa14_link_1, "
        "iiwa14_joint_2, iiwa14_link_2, iiwa14_joint_3, iiwa14_link_3, iiwa14_joint_4, iiwa14_link_4, "
        "iiwa14_joint_5, iiwa14_link_5, iiwa14_joint_6, iiwa14_link_6, iiwa14_joint_7, iiwa14_link_7, "
        "iiwa14_joint_flange, flange.",
    ),
    ("plan --start q:0,0", 3, f"start must have 7 joint values, got 2: {IIWA}."),
    (
        "plan --start q:nan,0,0,0,0,0,0",
        3,
        "start must hold finite numbers of at most 10000, got nan: give them in rad and metres.",
    ),
    (f"plan --scene empty --start {BEYOND}", 3, f"start {OUTSIDE}, or widen them with --widen-limits."),
    (f"plan --scene empty --goal {BEYOND}", 3, f"goal {OUTSIDE}, or widen them with --widen-limits."),
    (
        "plan --roadmap none.npz",
        3,
        "roadmap none.npz not found: 'planner roadmap build' makes one, 'planner plan' writes one too.",
    ),
    ("plan --out file/out", 3, "folder file/out cannot be written: FOLDER/file is not a folder; choose another place."),
    (
        "plan --acceleration 1e9",
        3,
        "acceleration limit of joint 'iiwa14_joint_1' must be from 1e-06 to 10000, got 1e+09 "
        "(--acceleration 1e+09): give another.",
    ),
    ("plan --limits no.yaml", 3, "joint limits no.yaml not found: check the path."),
    ("plan --beta 1.5", 2, "beta must be less than or equal to 1, got 1.5."),
    ("plan --beta nan", 2, "beta must be a finite number, got nan."),
    ("plan --nodes -5", 2, "nodes must be greater than or equal to 2, got -5."),
    ("plan --prescribed-time 0", 2, "prescribed time must be greater than or equal to 0.000000001, got 0.0."),
    ("plan --prescribed-time 1e308", 2, "prescribed time must be less than or equal to 1000000000, got 1e+308."),
    ("plan --margin -1", 2, "margin must be greater than or equal to 0, got -1.0."),
    (
        "plan --ik-tolerance 5",
        2,
        "ik tolerance must be metres and radians from 1e-06 to 0.1 m and 0.5 rad, got '5': give them as 1e-6,1e-4.",
    ),
    ("check", 2, "check must have a file or more, got none: name one."),
    ("plan --seed -1", 2, "seed must be greater than or equal to 0, got -1."),
    ("plan --start q:0,zero", 2, f"state 'q:0,zero' must hold numbers with commas between: give {FORMS}."),
    (
        "plan --start abc:1,2",
        2,
        f"state must be {FORMS}, got 'abc:1,2': give one of these, or --cell for states by robot.",
    ),
    ("plan --goal xyz:1,2", 2, f"state 'xyz:1,2' must have 3 numbers, got 2: give {FORMS}."),
    ("plan --start home --start=goal", 2, "--start must be given once, got it twice: remove one."),
    ("plan --out=", 2, "--out must have a value, got an empty text: leave it out."),
    ("plan --ik-solutions 3 --ik_solutions 4", 2, "--ik-solutions must be given once, got it twice: remove one."),
    ("plan --acceleration 0", 2, "acceleration must be greater than 0, got 0.0."),
    ("plan --velocity-scale nan", 2, "velocity scale must be a finite number, got nan."),
    (
        "plan --velocity-scale 0.5 --no-timing",
        2,
        "--no-timing leaves out the motion: leave it out, or all options of the motion.",
    ),
    (
        "plan --time-law blended --no-timing",
        2,
        "--no-timing leaves out the motion: leave it out, or all options of the motion.",
    ),
    (
        "plan --scene broken.yaml",
        3,
        "scene file broken.yaml must be valid YAML at line 2: did not find expected node content; correct the file.",
    ),
    (
        "plan --scene key.yaml",
        3,
        "scene file key.yaml: unknown key 'obstacels' (did you mean 'obstacles'?); remove it or check its spelling.",
    ),
    (
        "plan --scene list.yaml",
        3,
        "scene file list.yaml must be a mapping of keys to values, got list: keys are name, "
        "description, obstacles, carried, states, robots, allowed, constraints.",
    ),
    (
        "plan --scene box.yaml",
        3,
        "scene file box.yaml: 'obstacles.0.box.size.1' is wrong: Input should be greater than or equal "
        "to 0.000001 (got 0).",
    ),
    (
        "plan --scene cone.yaml",
        3,
        "scene file cone.yaml: 'obstacles.0' has type 'cone'; types are 'box', 'sphere', 'cylinder', "
        "'capsule', 'mesh', 'points', 'voxels', 'depth'.",
    ),
    (
        "plan --scene nan.yaml",
        3,
        "scene file nan.yaml: 'obstacles.0.sphere.radius' is wrong: Input should be a finite number (got nan).",
    ),
    (
        "plan --scene rotations.yaml",
        3,
        "scene file rotations.yaml: 'obstacles.0.sphere' is wrong: give rpy or quaternion, not both.",
    ),
    (
        "plan --scene zero.yaml",
        3,
        "scene file zero.yaml: 'obstacles.0.sphere' is wrong: quaternion must not be zero, "
        "got [0, 0, 0, 0]; [0, 0, 0, 1] is the identity.",
    ),
    (
        "plan --scene twice.yaml",
        3,
        "scene file twice.yaml: name 'a' is used twice; names must differ, also those of carried things.",
    ),
    ("plan --scene mesh.yaml", 3, "mesh file none.stl not found: check 'file', which is relative to the scene file."),
    (
        "plan --scene object.yaml",
        3,
        "scene file object.yaml must be valid YAML at line 1: could not determine a constructor for the "
        "tag 'tag:yaml.org,2002:python/object/apply:os.system'; correct the file.",
    ),
    ("plan --scene lump.yaml", 3, "start is in collision: 'iiwa14_link_4' and 'lump' touch; move it or the obstacle."),
    ("check none.json --robot planar_2r --scene window", 3, "motion none.json not found: check the path."),
    (
        "check page.html --robot planar_2r --scene window",
        3,
        "motion page.html must end in .json, .yaml, .csv or .mcap, got '.html'.",
    ),
    (
        "check three.csv --robot planar_2r --scene window",
        3,
        "motion three.csv must have 2 columns, got 3 without names: give one for each of joint_1, "
        "joint_2, or name the columns.",
    ),
    ("check three.csv --step 0", 2, "step must be a distance from 0.000001 to 1 m, got 0."),
    (
        "check two.csv --robot planar_2r --scene window --acceleration 3",
        2,
        "limits need a motion, two.csv holds a path without times: leave --limits, --velocity-scale, "
        "--acceleration, --jerk and their like out.",
    ),
    ("export .", 3, "trajectory trajectory.json not found: check the path, or plan a motion first."),
    ("export trajectory.json", 3, "trajectory trajectory.json not found: check the path, or plan a motion first."),
    ("export . --rate 0", 2, "rate must be from 0.1 to 10000 Hz, got 0."),
    (
        "follow no-points.yaml --robot panda",
        3,
        "tool path no-points.yaml: a tool path must have two points or more, got 0: add points.",
    ),
    (
        "follow nan-point.yaml --robot panda",
        3,
        "tool path nan-point.yaml: 'points.0.position.0' is wrong: Input should be a finite number (got nan).",
    ),
    ("follow mm.yaml --robot panda", 3, "tool path mm.yaml: point 1 must be within 20 m: give metres, not mm."),
    ("follow tube.yaml --robot panda", 3, "tool path tube.yaml: tube.position must be from 1e-06 to 0.1 m, got 0."),
    (
        "follow list.yaml --robot panda",
        3,
        "tool path list.yaml must be a mapping of keys to values, got list: keys are name, tube, "
        "points, approach, retreat.",
    ),
    (f"follow line.yaml --robot iiwa14 --scene empty --start {BEYOND}", 3, f"start {OUTSIDE}."),
    (
        f"{SEAM} --tool nowhere",
        3,
        "frame 'nowhere' not found; frames are universe, panda_link0, panda_joint1, panda_link1, "
        "panda_joint2, panda_link2, panda_joint3, panda_link3, panda_joint4, panda_link4, panda_joint5, "
        "panda_link5, panda_joint6, panda_link6, panda_joint7, panda_link7, panda_joint8, panda_link8, "
        "panda_hand_joint, panda_hand, panda_finger_joint1, panda_leftfinger, panda_finger_joint2, "
        "panda_rightfinger, panda_hand_tcp_joint, panda_hand_tcp.",
    ),
    (f"{SEAM} --tool-speed 0", 2, "tool speed must be greater than or equal to 0.00001, got 0.0."),
    (
        f"{SEAM} --tool-speed 0.1 --no-timing",
        2,
        "--tool-speed needs a motion in time: leave --tool-speed or --no-timing out.",
    ),
    ("task none.yaml", 3, "task file none.yaml not found: check the path."),
    ("task mug.yaml", 3, "step 1 picks 'mug', not found in the scene; obstacles are none."),
    ("task start.yaml", 3, f"start {OUTSIDE}."),
    ("task move.yaml", 3, f"step 1, the move, {OUTSIDE}."),
    (
        "task state.yaml",
        3,
        "step 1, the move, 'gone' not found; states of iiwa14 in the scene are there, home: give one of "
        f"them, or {FORMS}.",
    ),
    ("task forked.yaml", 3, "the robot has 2 tips: name one as its tool; tips are left, right."),
    ("task mug.yaml --beta 2", 2, "beta must be less than or equal to 1, got 2.0."),
    ("roadmap build r.npz --robot r2d2", 3, f"robot 'r2d2' not found; {ROBOTS}."),
    ("roadmap build r.npz --robot planar_2r --nodes 1", 2, "nodes must be greater than or equal to 2, got 1."),
    ("roadmap build . --robot planar_2r", 3, ". is a folder: give the name of a file."),
    (
        "roadmap info none.npz",
        3,
        "roadmap none.npz not found: 'planner roadmap build' makes one, 'planner plan' writes one too.",
    ),
    (f"robot-yaml {ARM} --joints a,,b", 2, "joints must be different names, got 'a,,b': name each once."),
    (f"robot-yaml {ARM} --joints a --group b", 2, "--group and --joints exclude each other: give one of them."),
    (
        f"robot-yaml {ARM} --group arm",
        3,
        "robot 'arm' has no SRDF, so there are no groups: give --srdf, or use --joints.",
    ),
    (
        f"robot-yaml {ARM} --joints nose",
        3,
        "joint 'nose' not found among the joints that move, turn, lift, bend: plan one of these.",
    ),
    (
        "sweep --roadmap none.npz",
        3,
        "roadmap none.npz not found: 'planner roadmap build' makes one, 'planner plan' writes one too.",
    ),
    ("verify none", 3, "none/proof.npz not found: plan with --certificate to write it."),
    ("view none.json", 3, "page none.html not found: check the path, or plan again."),
    ("view .", 3, "folder . must hold a plan.html or a sweep.html, got 0: name the file."),
    ("view . --state home", 2, "--state needs a robot at rest: leave out RESULT and --live."),
    ("view . --live", 3, "plan plan.json not found: check the path."),
    ("view --out .", 3, ". is a folder: give the name of a file."),
    ("view --state q:1,2", 3, f"state must have 7 joint values, got 2: {IIWA}."),
    ("view --robot ur99", 3, f"robot 'ur99' not found; {ROBOTS}."),
    ("view --beta 0.2", 2, "--start, --goal, --beta, --nodes, --seed and --roadmap need --live, and no RESULT."),
    (
        "view --live --robot planar_2r --scene empty --out state.html",
        2,
        "--out must be a scene file that ends in .yaml, got state.html.",
    ),
    (
        "view --live --robot planar_2r --scene empty --start q:0,9 --goal q:1,1",
        3,
        "start puts joint 'joint_2' at 9, outside its limits [-2.96706, 2.96706] by 6.03 rad: degrees? "
        "As degrees they would lie within limits; give them in rad.",
    ),
]
# each command that the parser refuses with exit code 2, and the first sentence of the parser
UNPARSED = [
    ("fly", "Unrecognized options: fly"),
    ("plan --beta much", "Error parsing --beta: could not convert string to float: 'much'"),
    (
        "plan --law newton",
        "invalid choice 'newton' for argument '--law'. Expected one of ('nominal', 'prescribed-time', "
        "'fixed-time', 'singularity-free').",
    ),
    ("plan --betta 0.5", "Unrecognized options: --betta, 0.5"),
    ("plan --goal", "Missing value for argument '--goal'. Expected 1 values."),
    (f"{SEAM} --goal home", "Unrecognized options: --goal, home"),
    (
        "schema roadmap",
        "invalid choice 'roadmap' for argument 'file'. Expected one of ('plan', 'sweep', 'scene', 'cell', 'robot', "
        "'serve').",
    ),
    ("sweep --beta 0.5", "Unrecognized options: --beta, 0.5"),
]


def refuse(words: str, run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[int, str, str]:
    """Run a command among the files, which it must not change."""
    monkeypatch.chdir(folder)
    for name, content in FILES.items():
        (folder / name).write_text(content)
    result = run(*words.split())
    assert {path.name: path.read_text() for path in folder.iterdir()} == FILES
    return result


@pytest.mark.parametrize(("words", "code", "sentence"), ROWS, ids=[row[0].replace(str(ROOT), "") for row in ROWS])
def test_refusals(
    words: str, code: int, sentence: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    got, output, error = refuse(words, run, tmp_path, monkeypatch)
    assert (got, output, error.partition("planner: error: ")[2]) == (
        code,
        "",
        f"{sentence.replace('FOLDER', str(tmp_path))}\n",
    )


@pytest.mark.parametrize(("words", "sentence"), UNPARSED, ids=[row[0].replace(str(ROOT), "") for row in UNPARSED])
def test_words_that_the_parser_refuses(
    words: str, sentence: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert_refused(refuse(words, run, tmp_path, monkeypatch), 2, sentence, tmp_path / "out")


def test_an_option_of_another_command_is_seen() -> None:
    """``run`` looks in every test whether a message names an option that its command has."""
    message = "planner: error: joint 1 is out of its limits: widen them with --widen-limits."
    assert_remedies_are_options(["plan"], message)
    assert_remedies_are_options(["task"], message.replace("--widen-limits", "'planner plan --widen-limits'"))
    with pytest.raises(AssertionError, match=r"task has no {'--widen-limits'}"):
        assert_remedies_are_options(["task"], message)
