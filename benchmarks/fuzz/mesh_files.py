"""One tetrahedron as a mesh file of every format that is read, and a robot that has a mesh."""

from __future__ import annotations

import struct

import numpy as np

_TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float32)[
    np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
]


def stl() -> bytes:
    """Binary STL."""
    facets = [struct.pack("<12fH", 0, 0, 1, *corners.ravel().tolist(), 0) for corners in _TETRAHEDRON]
    return b"\0" * 80 + struct.pack("<I", len(facets)) + b"".join(facets)


def stl_text() -> str:
    """STL as text."""
    facets = [
        "facet normal 0 0 1\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*p) for p in corners)
        + "endloop\nendfacet\n"
        for corners in _TETRAHEDRON
    ]
    return "solid part\n" + "".join(facets) + "endsolid part\n"


def obj() -> str:
    """Wavefront OBJ."""
    vertices = "".join("v {} {} {}\n".format(*p) for corners in _TETRAHEDRON for p in corners)
    return vertices + "".join(f"f {k} {k + 1} {k + 2}\n" for k in range(1, 13, 3))


def _ply_head(order: str) -> str:
    head = f"ply\nformat {order} 1.0\nelement vertex 12\nproperty float x\nproperty float y\nproperty float z\n"
    return head + "element face 4\nproperty list uchar int vertex_indices\nend_header\n"


def ply_of_bytes() -> bytes:
    """Binary PLY."""
    faces = b"".join(struct.pack("<B3i", 3, k, k + 1, k + 2) for k in range(0, 12, 3))
    return _ply_head("binary_little_endian").encode() + _TETRAHEDRON.astype("<f4").tobytes() + faces


def dae() -> str:
    """COLLADA."""
    numbers = " ".join(map(str, _TETRAHEDRON.ravel().tolist()))
    params = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    source = (
        f'<source id="p"><float_array id="a" count="36">{numbers}</float_array><technique_common>'
        f'<accessor source="#a" count="12" stride="3">{params}</accessor></technique_common></source>'
    )
    mesh = (
        f'<mesh>{source}<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="4">'
        f'<input semantic="VERTEX" source="#v" offset="0"/><p>{" ".join(map(str, range(12)))}</p></triangles></mesh>'
    )
    return (
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/>'
        f'<up_axis>Z_UP</up_axis></asset><library_geometries><geometry id="g">{mesh}</geometry></library_geometries>'
        '<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>'
        '</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )


def ply() -> str:
    """PLY as text."""
    vertices = "".join("{} {} {}\n".format(*p) for corners in _TETRAHEDRON for p in corners)
    return _ply_head("ascii") + vertices + "".join(f"3 {k} {k + 1} {k + 2}\n" for k in range(0, 12, 3))


def robot_with_mesh(name: str) -> str:
    """A URDF of one joint whose link is the mesh file ``name``, ten times smaller."""
    body = f'<collision><geometry><mesh filename="{name}" scale="0.1 0.1 0.1"/></geometry></collision>'
    joint = (
        '<parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
    )
    return (
        f'<robot name="meshed"><link name="a"/><link name="b">{body}</link>'
        f'<joint name="j" type="revolute"><origin xyz="0 0 0.1"/>{joint}</joint></robot>'
    )
