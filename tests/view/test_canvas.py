"""A recorded scene: the same bytes twice, every shape where it stands, and data that cannot end its script."""

from __future__ import annotations

import base64
import gzip
from pathlib import Path
from typing import Any

import numpy as np
import umsgpack

from planner.robot.poses import pose
from planner.robot.shapes import Box, Capsule, Cylinder, Shape, Sphere
from planner.view.canvas import Canvas, render_page
from tests.browser import page_data

GREY = (0.5, 0.5, 0.5, 1.0)
SHAPES: list[Shape] = [Box((0.1, 0.2, 0.3)), Sphere(0.1), Cylinder(0.1, 0.4), Capsule(0.1, 0.4)]


def drawn() -> Canvas:
    canvas = Canvas()
    for k, shape in enumerate(SHAPES):
        canvas.shape(f"things/{k}", shape, pose([k, 0.0, 0.0]), GREY)
    canvas.points("dots", np.eye(3), np.zeros((3, 3)), 0.02)
    canvas.segments("lines", np.eye(3)[[0, 1, 1, 2]], np.zeros((4, 3)))
    return canvas


def unpacked(canvas: Canvas) -> list[dict[str, Any]]:
    """The commands as the page's script decodes them."""
    content, lengths = canvas.pack()
    data, ends = gzip.decompress(base64.b64decode(content)), np.cumsum(lengths)
    assert ends[-1] == len(data)
    return [umsgpack.unpackb(data[end - length : end]) for end, length in zip(ends, lengths, strict=True)]


def test_the_same_scene_is_the_same_bytes_and_no_two_objects_share_a_name() -> None:
    assert drawn().pack() == drawn().pack()
    sent = [command["object"] for command in unpacked(drawn()) if command["type"] == "set_object"]
    names = [part["uuid"] for one in sent for part in (one["object"], *one["geometries"], *one["materials"])]
    assert len(set(names)) == len(names) == 3 * (len(SHAPES) + 2)


def test_every_object_is_sent_with_its_place() -> None:
    commands = unpacked(drawn())
    kinds = [command["type"] for command in commands]
    assert kinds.count("set_object") == len(SHAPES) + 2
    for k, shape in enumerate(SHAPES):
        (sent,) = (c for c in commands if c["type"] == "set_transform" and c["path"].endswith(f"things/{k}"))
        matrix = np.reshape(sent["matrix"], (4, 4)).T
        assert matrix[:3, 3].tolist() == [k, 0, 0]
        # three.js's cylinders lie along y, ours along z
        axis = matrix[:3, :3] @ [0, 1, 0] if isinstance(shape, Cylinder) else matrix[:3, :3] @ [0, 0, 1]
        np.testing.assert_allclose(np.abs(axis), [0, 0, 1], atol=1e-12)


def test_a_page_is_one_file_whatever_its_title(tmp_path: Path) -> None:
    html = render_page(drawn(), {"answer": "@@VIEWER@@"}, "<b>@@SCENE@@ \ud800")
    (tmp_path / "page.html").write_text(html)
    assert page_data(tmp_path / "page.html")["answer"] == "@@VIEWER@@"
    assert "&lt;b&gt;@@SCENE@@ ?" in html
    assert html.rstrip().endswith("</html>")
    assert 'src="http' not in html
    assert render_page(drawn(), {}, "a") == render_page(drawn(), {}, "a")
