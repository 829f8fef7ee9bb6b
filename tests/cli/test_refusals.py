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

ROWS = [
    ("fly", 2, "fly"),
    ("plan --robot r2d2", 3, "robot 'r2d2' not found"),
    ("plan --robot nowhere/arm.urdf", 3, "nowhere/arm.urdf not found"),
    ("plan --scene moon", 3, "scene 'moon' not found"),
    ("plan --goal xyz:1e200,0,0", 3, "of at most 10000, got 1e+200: give them in rad and metres"),
    ("plan --goal xyz:3,0,0.5", 3, "beyond the arm's reach"),
    ("plan --goal home --goal nowhere", 3, "goal 'nowhere' is not among the scene's states"),
    ("plan --goal pose:0.4,0,0.6,0,0,0,0", 3, "zero length"),
    ("plan --tool tol0", 3, "frame 'tol0' not found; frames are"),
    ("plan --start q:0,0", 3, "2 joint values, iiwa14 has 7"),
    ("plan --start q:nan,0,0,0,0,0,0", 3, "must hold finite numbers of at most 10000, got nan"),
    (f"plan --scene empty --start {BEYOND}", 3, "--widen-limits"),
    (f"plan --scene empty --goal {BEYOND}", 3, "--widen-limits"),
    ("plan --roadmap none.npz", 3, "none.npz not found"),
    ("plan --out file/out", 3, "cannot be written"),
    ("plan --acceleration 1e9", 3, "acceleration"),
    ("plan --limits no.yaml", 3, "no.yaml"),
    ("plan --beta 1.5", 2, "beta must be less than or equal to 1, got 1.5."),
    ("plan --beta nan", 2, "beta must be a finite number"),
    ("plan --beta much", 2, "--beta"),
    ("plan --nodes -5", 2, "nodes must be greater than or equal to 2, got -5."),
    ("plan --prescribed-time 0", 2, "prescribed time must be greater than or equal to"),
    ("plan --prescribed-time 1e308", 2, "prescribed time must be less than"),
    ("plan --margin -1", 2, "margin must be greater than or equal to 0"),
    ("plan --ik-tolerance 5", 2, "ik tolerance must be metres and radians"),
    ("plan --seed -1", 2, "seed must be greater than or equal to 0"),
    ("plan --law newton", 2, "'newton'"),
    ("plan --start q:0,zero", 2, "no number"),
    ("plan --start abc:1,2", 2, "starts with 'abc:'"),
    ("plan --goal xyz:1,2", 2, "has 2 numbers and must have 3"),
    ("plan --betta 0.5", 2, "--betta"),
    ("plan --start home --start=goal", 2, "--start must be given once"),
    ("plan --out=", 2, "--out must have a value"),  # it would be the folder that the shell stands in
    ("plan --ik-solutions 3 --ik_solutions 4", 2, "--ik-solutions must be given once"),
    ("plan --goal", 2, "goal"),
    ("plan --acceleration 0", 2, "acceleration"),
    ("plan --velocity-scale nan", 2, "velocity scale"),
    ("plan --velocity-scale 0.5 --no-timing", 2, "--no-timing"),
    ("plan --time-law blended --no-timing", 2, "--no-timing"),
    ("plan --scene broken.yaml", 3, "not valid YAML"),
    ("plan --scene key.yaml", 3, "unknown key 'obstacels'"),
    ("plan --scene list.yaml", 3, "no mapping"),
    ("plan --scene box.yaml", 3, "greater than or equal to 0.000001"),
    ("plan --scene cone.yaml", 3, "'cone'"),
    ("plan --scene nan.yaml", 3, "obstacles.0"),
    ("plan --scene rotations.yaml", 3, "not both"),
    ("plan --scene zero.yaml", 3, "zero length"),
    ("plan --scene twice.yaml", 3, "used twice"),
    ("plan --scene mesh.yaml", 3, "none.stl not found"),
    ("plan --scene object.yaml", 3, "not valid YAML"),
    ("plan --scene lump.yaml", 3, "start is in collision: 'iiwa14_link_"),
    ("check", 2, "PATH"),
    ("check none.json --robot planar_2r --scene window", 3, "none.json not found"),
    ("check page.html --robot planar_2r --scene window", 3, "must end in .json, .yaml, .csv or .mcap, got '.html'"),
    ("check three.csv --robot planar_2r --scene window", 3, "must have 2 columns, got 3 without names"),
    ("check three.csv --step 0", 2, "step must be"),
    ("check two.csv --robot planar_2r --scene window --acceleration 3", 2, "leave --limits"),
    ("export .", 3, ""),
    ("export trajectory.json", 3, "check the path, or plan a motion first"),
    ("export . --rate 0", 2, "rate"),
    ("follow no-points.yaml --robot panda", 3, "two points or more, got 0"),
    ("follow nan-point.yaml --robot panda", 3, "finite"),
    ("follow mm.yaml --robot panda", 3, "must be within 20 m: give metres, not mm"),
    ("follow tube.yaml --robot panda", 3, "tube.position"),
    ("follow list.yaml --robot panda", 3, "mapping"),
    (f"follow line.yaml --robot iiwa14 --scene empty --start {BEYOND}", 3, "bring it inside."),
    (f"{SEAM} --tool nowhere", 3, "nowhere"),
    (f"{SEAM} --tool-speed 0", 2, "tool speed must be"),
    (f"{SEAM} --goal home", 2, "--goal"),
    (f"{SEAM} --tool-speed 0.1 --no-timing", 2, "--tool-speed needs a motion in time"),
    ("task none.yaml", 3, "task file none.yaml not found"),
    ("task mug.yaml", 3, "not found in the scene"),
    ("task start.yaml", 3, "bring it inside."),
    ("task move.yaml", 3, "bring it inside."),
    ("task state.yaml", 3, "'gone' is not among the scene's states"),
    ("task forked.yaml", 3, "the robot has 2 tips: name one as its tool"),
    ("task mug.yaml --beta 2", 2, "beta"),
    ("roadmap build r.npz --robot r2d2", 3, "robot 'r2d2' not found"),
    ("roadmap build r.npz --robot planar_2r --nodes 1", 2, "nodes must be greater than or equal to 2"),
    ("roadmap build . --robot planar_2r", 3, "is a folder"),
    ("roadmap info none.npz", 3, "not found"),
    (f"robot-yaml {ARM} --joints a,,b", 2, "name each once"),
    (f"robot-yaml {ARM} --joints a --group b", 2, "give one of them"),
    (f"robot-yaml {ARM} --group arm", 3, "give --srdf, or use --joints"),
    (f"robot-yaml {ARM} --joints nose", 3, "joint 'nose' not found among"),
    ("schema roadmap", 2, "sweep"),
    ("sweep --beta 0.5", 2, "--beta"),
    ("sweep --roadmap none.npz", 3, "none.npz not found"),
    ("verify none", 3, "plan with --certificate"),
    ("view none.json", 3, "none.html not found"),
    ("view .", 3, "must hold a plan.html or a sweep.html, got 0"),
    ("view . --state home", 2, "leave out RESULT"),
    ("view . --live", 3, "plan.json"),
    ("view --out .", 3, "is a folder: give the name of a file"),
    ("view --state q:1,2", 3, "2 joint values, iiwa14 has 7"),
    ("view --robot ur99", 3, "robot.yaml ('planner robot-yaml' writes one)"),
    ("view --beta 0.2", 2, "need --live"),
    ("view --live --robot planar_2r --scene empty --out state.html", 2, "ends in .yaml"),
    ("view --live --robot planar_2r --scene empty --start q:0,9 --goal q:1,1", 3, "outside its limits"),
]


@pytest.mark.parametrize(("words", "code", "text"), ROWS, ids=[row[0].replace(str(ROOT), "") for row in ROWS])
def test_refusals(words: str, code: int, text: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, content in FILES.items():
        (tmp_path / name).write_text(content)
    assert_refused(run(*words.split()), code, text, tmp_path / "out")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == FILES


def test_an_option_of_another_command_is_seen() -> None:
    """``run`` looks in every test whether a message names an option that its command has."""
    told = "planner: error: joint 1 is out of its limits: widen them with --widen-limits."
    assert_remedies_are_options(["plan"], told)
    assert_remedies_are_options(["task"], told.replace("--widen-limits", "'planner plan --widen-limits'"))
    with pytest.raises(AssertionError, match=r"task has no {'--widen-limits'}"):
        assert_remedies_are_options(["task"], told)
