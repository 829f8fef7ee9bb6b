"""COLLADA files: geometry that pycollada would misread is refused, unit and axis are noted."""

import pytest

from tests.refusals import refusal_of
from tests.robot.files.test_meshes import read, volume

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


def test_nodes_place_geometry_and_materials_do_not_matter() -> None:
    """Of parts with materials of their own, an earlier reader took the corners of one for those of another."""
    half = '<triangles material="{}" count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>{}</p></triangles>'
    whole = TETRAHEDRON[TETRAHEDRON.index("<triangles") : TETRAHEDRON.index("</mesh>")]
    text = TETRAHEDRON.replace(whole, half.format("a", "0 2 1 0 1 3") + half.format("b", "0 3 2 1 2 3"))
    moves = "<matrix>1 0 0 5 0 0 -1 0 0 1 0 0 0 0 0 1</matrix><scale>2 2 2</scale>"
    bound = '<technique_common><instance_material symbol="a" target="#gone"/></technique_common>'
    placed = f'{moves}<instance_geometry url="#g"><bind_material>{bound}</bind_material></instance_geometry>'
    shared = f'<library_nodes><node id="m">{placed}</node></library_nodes>'
    text = text.replace("<library_visual", f"{shared}<library_visual", 1)
    text = text.replace('<instance_geometry url="#g"/></node></visual', '<instance_node url="#m"/></node></visual')
    assert "instance_node" in text
    found = read(text, "dae")
    expected = {(5.0, 0.0, 0.0), (7.0, 0.0, 0.0), (5.0, 0.0, 4.0), (5.0, -6.0, 0.0)}
    assert {tuple(row) for row in found.vertices.tolist()} == expected
    assert volume(found) == pytest.approx(8.0)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        *[("0 2 1 0", indices) for indices in ("0 2 9 0", "0 2 x 0")],
        *[("1 0 0 0 2", numbers) for numbers in ("1 x 0 0 2", "1 0 0 2")],
        *[('url="#g"', 'url="#h"'), ("instance_geometry", "instance_controller"), ("triangles", "spline")],
        ('<node id="n">', '<node id="n"><skew>45 0 1 0 1 0 0</skew>'),
    ],
)
def test_geometry_that_would_be_misread_is_refused(old: str, new: str) -> None:
    assert volume(read(TETRAHEDRON, "dae")) == pytest.approx(1.0)
    assert old in TETRAHEDRON
    assert "mesh file" in refusal_of(lambda: read(TETRAHEDRON.replace(old, new), "dae"))
