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
