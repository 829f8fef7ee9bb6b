"""MoveIt's scene text, old and new, whole and broken."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from planner.base.errors import SceneError
from planner.models.files.moveit.scene_text import scene_text
from planner.models.scene import Scene
from planner.models.shapes import Box, Cylinder
from tests.models.files.moveit.samples import BOX, scene

OLD_TEXT = (
    "(noname)++\n* Box0\n1\nbox\n0.1 0.2 0.3\n1 2 3\n0 0 0 1\n0 0 0 0\n"
    "* Can\n1\ncylinder\n0.03 0.14\n0 0 1\n0 0 0 1\n0 0 0 0\n.\n"
)
NEW_TEXT = "(name)\n* Box0\n1 0 0\n0 0 0 1\n1\nbox\n0.1 0.2 0.3\n0 2 3\n0 0 0 1\n0 0 0 0\n0\n.\n"


def test_scene_text_of_both_ages() -> None:
    box, can = scene_text(OLD_TEXT, Path("a.scene")).obstacles
    assert (box.shape, can.shape) == (Box((0.1, 0.2, 0.3)), Cylinder(0.03, 0.14))
    np.testing.assert_allclose(box.placement[:3, 3], [1, 2, 3])
    (new,) = scene_text(NEW_TEXT, Path("a.scene")).obstacles
    np.testing.assert_allclose(new.placement[:3, 3], [1, 2, 3])


@pytest.mark.parametrize(
    "text", ["", OLD_TEXT[:40], OLD_TEXT.replace("box", "teapot"), OLD_TEXT.replace("0.1 0.2 0.3", "0.1 x")]
)
def test_broken_scene_text(text: str) -> None:
    with pytest.raises(SceneError, match=r"a\.scene"):
        scene_text(text, Path("a.scene"))


def test_a_scene_file_of_each_kind_loads(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(OLD_TEXT)
    (tmp_path / "b.yaml").write_text(yaml.safe_dump(scene(BOX)))
    assert [o.name for o in Scene.load(str(tmp_path / "a.scene")).obstacles] == ["Box0", "Can"]
    assert [o.name for o in Scene.load(str(tmp_path / "b.yaml")).obstacles] == ["crate"]
