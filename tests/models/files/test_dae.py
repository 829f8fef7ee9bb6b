"""DAE files: what their reader would not survive is refused first."""

from __future__ import annotations

import pytest

from planner.models.files.dae import dae_fault

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


def test_instances_that_are_few_are_fine() -> None:
    assert dae_fault(scene(twice(10), "<instance_node url='#n10'/><instance_node url='#missing'/>")) is None
