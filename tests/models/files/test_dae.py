"""DAE files: what their reader would not survive is refused first."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.models.files.dae import dae_fault, dae_notes
from planner.models.robot import Robot
from planner.models.scene import Scene
from planner.models.shapes import Mesh

DAE = "<COLLADA><mesh><float_array count='3'>0 0 1</float_array><p>0 1 2</p></mesh></COLLADA>"


@pytest.mark.parametrize(
    "bad",
    [
        DAE.replace("<p>0", "<p>.nan"),  # Assimp allocates until there is nothing left
        DAE.replace("<p>0", "<p>-1"),
        DAE.replace("count='3'", "count='999999999'"),
        DAE.replace("0 0 1", "0 0 x"),
        DAE.replace("<mesh>", "<x>" * 300 + "</x>" * 300 + "<mesh>"),
        DAE[:30],
    ],
)
def test_a_dae_that_does_not_fit_never_reaches_its_reader(bad: str) -> None:
    assert dae_fault(DAE.encode()) is None
    assert dae_fault(bad.encode()) is not None


def scene(nodes: str, top: str, indices: str = "0 1 2") -> bytes:
    mesh = f"<geometry id='g'><mesh><triangles><p>{indices}</p></triangles></mesh></geometry>"
    top = f"<visual_scene><node>{top}</node></visual_scene>"
    return f"<COLLADA>{mesh}<library_nodes>{nodes}</library_nodes>{top}</COLLADA>".encode()


def twice(count: int) -> str:
    """Nodes n1, n2 and so on, each of them twice the one before."""
    below = ("<instance_geometry url='#g'/>", *(f"<instance_node url='#n{k}'/>" * 2 for k in range(count)))
    return "".join(f"<node id='n{k}'>{inside}</node>" for k, inside in enumerate(below))


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (scene(twice(40), "<instance_node url='#n40'/>"), "unfold to"),
        (scene("", "<instance_geometry url='#g'/>" * 20_000, "0 1 2 " * 1000), "unfold to"),
        (
            scene(
                "<node id='n'><instance_node url='#n'/><instance_node url='#n'/></node>", "<instance_node url='#n'/>"
            ),
            "nests",
        ),
        (
            scene(
                "".join(f"<node id='n{k + 1}'><instance_node url='#n{k}'/></node>" for k in range(1000)),
                "".join(f"<instance_node url='#n{k}'/>" for k in range(1000)),
            ),
            "nests nodes more than 200 deep",
        ),
        (
            scene(
                "<controller id='c'><skin source='#g'/></controller>",
                "<node><instance_controller url='#c'/></node>" * 20_000,
                "0 1 2 " * 1000,
            ),
            "unfold to",
        ),
    ],
)
def test_a_few_lines_make_no_mesh_beyond_memory(bad: bytes, words: str) -> None:
    assert words in (dae_fault(bad) or "")


def test_instances_that_are_few_are_fine_and_of_what_is_not_there_are_not() -> None:
    assert dae_fault(scene(twice(10), "<instance_node url='#n10'/>")) is None
    missing = scene(twice(10), "<instance_node url='#n10'/><instance_geometry url='#missing'/>")
    assert "has a <instance_geometry> of '#missing', which is not in it" in (dae_fault(missing) or "")


ASSET = "<COLLADA><asset><unit {unit}/>{axis}</asset></COLLADA>"


@pytest.mark.parametrize(
    ("unit", "axis", "words"),
    [
        ('name="meter" meter="1"', "<up_axis>Z_UP</up_axis>", []),
        ("meter='1.0000000000'", "", []),
        ('meter="0.01" name="centimeter"', "<up_axis>Z_UP</up_axis>", ["its unit is '0.01' m"]),
        ("meter='inch'", "", ["its unit is 'inch' m"]),
        ('meter="1"', "<up_axis> Y_UP </up_axis>", ["up_axis"]),
        ('meter="0.001"', "<up_axis>X_UP</up_axis>", ["its unit is '0.001' m", "up_axis"]),
    ],
)
def test_what_is_not_followed_is_noted(tmp_path: Path, unit: str, axis: str, words: list[str]) -> None:
    (tmp_path / "part.DAE").write_text(ASSET.format(unit=unit, axis=axis))
    (tmp_path / "part.stl").write_text(ASSET.format(unit="meter='7'", axis=""))
    found = list(dae_notes([tmp_path / name for name in ("part.stl", "part.DAE", "part.DAE", "none.dae")]))
    assert len(found) == len(words)
    for note, said in zip(found, words, strict=True):
        assert said in note.text
        assert "part.DAE" in note.text
        assert note.grave == ("unit" in said)


TETRAHEDRON = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/></asset><library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="pa" count="12">0 0 0 1 0 0 0 2 0 0 0 3</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node id="n">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
SCENE = "obstacles: [{name: wedge, type: mesh, file: wedge.dae, scale: 0.01, position: [2, 0, 0]}]"
ARM = """<robot name="arm"><link name="base"/><link name="hand"><collision><geometry>
<mesh filename="file://{folder}/wedge.dae" scale="0.01 0.01 0.01"/></geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


def test_scenes_and_robots_note_it(tmp_path: Path) -> None:
    """The numbers of the file are not scaled by its unit."""
    (tmp_path / "wedge.dae").write_text(TETRAHEDRON)
    (tmp_path / "scene.yaml").write_text(SCENE)
    (tmp_path / "arm.urdf").write_text(ARM.format(folder=tmp_path))
    scene, robot = Scene.load(tmp_path / "scene.yaml"), Robot.load(tmp_path / "arm.urdf")
    for shape in (scene.obstacles[0].shape, robot.bodies[0].shape):
        assert isinstance(shape, Mesh)
        assert shape.vertices.max() == 0.03
    for found in (scene.notes, robot.notes):
        assert ["its unit is '0.01' m" in note.text for note in found] == [True]
