"""Drawn objects stand where the kinematics puts them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from planner.kinematics.forward import tool_positions
from planner.robot.moving import KnownMotion, MovingObstacle
from planner.robot.poses import pose
from planner.robot.robot import with_carried
from planner.robot.shapes import Box, Carried, Sphere
from planner.view import drawing
from planner.view.canvas import Canvas
from planner.view.drawing import (
    draw_path,
    draw_roadmap,
    draw_robot,
    draw_scene,
    joint_matrices,
    moving_data,
    select_part,
)
from tests.view.test_canvas import unpacked
from tests.worlds import load, make_post, post_roadmap, random_q

ROBOT = load("planar_2r")


def paths(canvas: Canvas, kind: str) -> list[str]:
    return [c["path"].removeprefix("/meshcat/") for c in canvas.commands if c["type"] == kind]


@pytest.mark.parametrize("name", ["planar_2r", "ur5"])
def test_joint_frames_are_pinocchios(name: str) -> None:
    robot, states = load(name), random_q(load(name), 3)
    for q, matrices in zip(states, joint_matrices(robot, states), strict=True):
        data = robot.model.createData()
        pin.forwardKinematics(robot.model, data, q)
        for joint, matrix in enumerate(matrices, start=1):
            np.testing.assert_allclose(matrix, data.oMi[joint].homogeneous, atol=1e-12)


def is_red(command: dict) -> bool:
    colour = command["object"]["materials"][0]["color"]
    return colour >> 16 > 200 and colour & 0xFF < 60


def test_a_moving_obstacle_is_drawn_at_its_start_with_its_path() -> None:
    motion = KnownMotion([0, 2, 3], [pose([1, 0, 0]), pose([1, 1, 0], [0, 0, 3.0]), pose([1, 1, 0])])
    canvas, moving = Canvas(), (MovingObstacle("cart", Box((0.1, 0.2, 0.3)), motion),)
    scene = replace(make_post().world.scene, moving=moving)
    assert draw_scene(canvas, scene, ["cart"]) == {"obstacles/0": "thing0", "moving/0/shape": "cart"}
    assert paths(canvas, "set_object") == ["obstacles/0", "moving/0/shape", "ways/0"]
    assert [is_red(c) for c in canvas.commands if c["type"] == "set_object"] == [False, True, False]
    (item,) = moving_data(scene)
    assert {0.0, 2.0, 3.0} <= set(item["times"])
    for t, position, quaternion in zip(item["times"], item["positions"], item["quaternions"], strict=True):
        np.testing.assert_allclose(pose(position, quaternion=quaternion), motion.at(t)[0], atol=1e-12)
    turns = np.array(item["quaternions"])
    assert (np.abs((turns[1:] * turns[:-1]).sum(axis=1)) > np.cos(np.pi / 4) - 1e-9).all()  # half a turn apart at most


def test_a_roadmap_is_drawn_at_its_tool_positions() -> None:
    canvas, roadmap = Canvas(), post_roadmap()
    data = draw_roadmap(canvas, roadmap, ROBOT, select_part(roadmap))
    assert paths(canvas, "set_object") == ["roadmap/nodes", "roadmap/edges", "start/0", "goal/0"]
    assert data["edges"] == roadmap.edges.tolist()
    assert data["w"] == pytest.approx(roadmap.manipulability.tolist(), abs=1e-7)
    nothing = replace(roadmap.part(np.ones(len(roadmap.nodes), bool), np.zeros(len(roadmap.edges), bool)))
    canvas = Canvas()
    draw_roadmap(canvas, nothing, ROBOT, select_part(nothing))
    assert "roadmap/edges" not in paths(canvas, "set_object")


def test_a_large_roadmap_is_drawn_with_some_edges_their_ends_and_true_components(monkeypatch) -> None:
    monkeypatch.setattr(drawing, "MOST_EDGES", 5)
    canvas, roadmap = Canvas(), post_roadmap()
    nodes, edges = select_part(roadmap)
    assert edges.sum() == 5
    assert nodes[roadmap.edges[edges]].all()
    assert nodes[roadmap.starts].all()
    assert nodes[roadmap.goals].all()
    assert nodes.sum() <= 2 * 5 + len(roadmap.starts) + len(roadmap.goals)
    data = draw_roadmap(canvas, roadmap, ROBOT, (nodes, edges))
    assert np.array_equal(np.flatnonzero(nodes)[data["edges"]], roadmap.edges[edges])
    assert data["component"] == roadmap.components[nodes].tolist()


def test_a_path_is_a_tube_around_the_tools_way() -> None:
    canvas, path = Canvas(), np.array([[-1.0, 0.8], [1.0, 0.8]])
    draw_path(canvas, "path", ROBOT, path)
    (geometry,) = canvas.commands[0]["object"]["geometries"]
    points = np.frombuffer(geometry["data"]["attributes"]["position"]["array"].data, np.float32).reshape(-1, 3)
    dense = tool_positions(ROBOT, path[0] + np.linspace(0.0, 1.0, 2000)[:, None] * (path[1] - path[0]))
    off = np.linalg.norm(points[:, None] - dense[None], axis=2).min(axis=1)
    assert 0.004 < off.max() < 0.013


def test_contacts_are_red_and_a_carried_body_is_drawn_as_both_kinds() -> None:
    robot = with_carried(load("ur5"), [Carried("tool0", "cup", Sphere(0.05), np.eye(4))])
    for touching in (frozenset[str](), frozenset({"cup"}), frozenset({robot.bodies[0].link})):
        canvas = Canvas()
        names, bodies = draw_robot(canvas, robot, np.zeros(6), touching)
        assert list(names.values()).count("cup") == 2
        assert len(names) == len(bodies) + len(robot.bodies)
        drawn = {c["path"].removeprefix("/meshcat/"): c for c in unpacked(canvas) if c["type"] == "set_object"}
        assert set(drawn) == set(names)
        assert {names[path] for path, command in drawn.items() if is_red(command)} == touching
