"""Points, voxels and depth images: which part of space counts as solid, against grids and rays counted one by one."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis.extra.numpy import arrays
from mcap_ros2.writer import Writer
from PIL import Image
from pypcd4 import PointCloud

import planner
from planner import DepthImage, Obstacle, Points, Scene, Voxels
from planner.base.errors import PlannerError, SceneError
from planner.robot.clouds import estimate_covering_radius, merge_cells, split_blocks, split_regions
from planner.robot.files.clouds import decode_octomap, read_depth, read_points, read_voxels, voxels_of_leaves
from planner.robot.solids import is_closed
from tests.random_shapes import QUICK

POINT_CLOUD = """std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: sensor_msgs/PointField
string name
uint32 offset
uint8 datatype
uint32 count
"""
RNG = np.random.default_rng(3)
XYZ = np.round(RNG.random((60, 3)), 3)


@QUICK
@given(arrays(bool, (4, 5, 3)))
def test_cuboids_are_disjoint_and_cover_just_the_solid_cells(occupied: np.ndarray) -> None:
    count = np.zeros(occupied.shape, dtype=int)
    for x, y, z, x_end, y_end, z_end in merge_cells(occupied):
        count[x:x_end, y:y_end, z:z_end] += 1
    assert (count == occupied).all()


def test_a_voxel_is_drawn_as_a_closed_surface_that_faces_outwards() -> None:
    cube = Voxels(np.ones((1, 1, 1)), 0.5, (1.0, 2.0, 3.0))
    corners = cube.vertices[cube.triangles]
    assert is_closed(cube.triangles)
    assert np.einsum("ki,ki->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6 == pytest.approx(0.125)
    assert (cube.vertices.min(axis=0) == [1, 2, 3]).all()


def test_the_radius_is_the_sum_of_three_terms_and_says_where_it_is_estimated() -> None:
    given_radius = Points(XYZ, 0.01, noise=0.002, calibration=0.003)
    assert given_radius.radius == pytest.approx(0.015)
    assert not given_radius.is_estimated
    estimated = Points(XYZ)
    assert estimated.is_estimated
    note = Scene("s", [{"name": "a", "type": "box", "size": [1, 1, 1]}]).notes
    assert note == ()
    (text,) = (each.text for each in Scene("s", split_regions("a", estimated, np.eye(4), {})).notes)
    assert "60 points" in text
    assert "(estimated)" in text


@pytest.mark.parametrize("spacing", [0.01, 0.1])
def test_the_estimate_is_no_less_than_the_covering_radius_of_a_grid_and_of_random_samples(spacing: float) -> None:
    grid = spacing * np.array([[x, y, 0] for x in range(40) for y in range(40)], dtype=float)
    assert spacing / np.sqrt(2) <= estimate_covering_radius(grid) <= 3 * spacing
    drawn = np.column_stack([RNG.random((4000, 2)), np.zeros(4000)])
    surface = np.column_stack([0.05 + 0.9 * RNG.random((20_000, 2)), np.zeros(20_000)])
    gap = np.min([np.linalg.norm(surface - point, axis=1) for point in drawn], axis=0).max()
    assert gap <= estimate_covering_radius(drawn) <= 2.5 * gap


def test_samples_that_are_not_finite_are_dropped_and_counted() -> None:
    cloud = Points(np.vstack([XYZ, XYZ[:5], [[np.nan, 0, 0], [0, np.inf, 0]]]), 0.01)
    assert (len(cloud.vertices), cloud.dropped) == (60, 2)


def test_a_million_duplicates_are_one_point_each_and_millimetres_get_a_hint() -> None:
    cloud = Points(np.tile(XYZ, (17_000, 1)), 0.01)
    np.testing.assert_array_equal(cloud.vertices, XYZ)
    (note,) = Scene("s", (Obstacle("a", Points(1e3 * XYZ, 10.0), np.eye(4)),)).notes
    assert note.text.endswith("if its file is in millimetres, give scale: 0.001.")


def test_a_million_duplicates_are_merged_and_counted_in_the_notes() -> None:
    cloud = Points(np.tile(XYZ, (20_000, 1)), 0.01)
    assert (len(cloud.vertices), cloud.merged) == (60, 1_199_940)
    (note,) = Scene("s", (Obstacle("a", cloud, np.eye(4)),)).notes
    assert "1199940 samples equal another" in note.text


def test_a_cloud_in_millimetres_gets_a_hint_also_in_blocks_and_these_stay_few() -> None:
    cloud = Points(1000.0 * RNG.random((3000, 3)) * [1, 1, 0], 20.0)
    blocks = split_blocks(Obstacle("a", cloud, np.eye(4)))
    assert len(blocks) < 1100
    for scene in (Scene("s", (Obstacle("a", cloud, np.eye(4)),)), Scene("s", tuple(blocks))):
        (note,) = scene.notes
        assert "scale: 0.001" in note.text


def test_a_grid_of_more_cells_than_memory_holds_is_refused_with_the_remedy() -> None:
    image = DepthImage(np.ones((8, 8)), (9, 9, 4, 4), np.eye(4), unknown="solid everywhere", pitch=1e-3)
    for make in (
        image.unknown_space,
        lambda: Voxels(np.broadcast_to(True, (1000, 1000, 100)), 0.1),
        lambda: voxels_of_leaves([(np.zeros(3), 0.1), (np.full(3, 1e3), 0.1)], 0.1),
    ):
        with pytest.raises(SceneError, match=r"must give at most 50000000 cells, got .* give larger cells"):
            make()


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Points(np.full((3, 3), np.nan), 0.1), "Points.xyz must hold a finite point, got none."),
        (lambda: Points(XYZ, 0.0), "Points.radius must be above 0 m, got 0: give the covering radius of the samples."),
        (lambda: Points(XYZ, -1.0), "Points.radius must be at least 0 m, got -1."),
        (lambda: Points(XYZ[:4]), "Points.radius must be given for 4 points: an estimate needs at least 9."),
        (lambda: Voxels(np.ones((2, 2, 2)), 0.0), "Voxels.pitch must be above 0 m, got 0."),
        (lambda: split_regions("a", Points(XYZ, 0.1), np.eye(4), {"b": (5, 5, 5, 6, 6, 6)}), "'a': region 'b' must"),
    ],
)
def test_numbers_that_make_no_cloud_are_refused(make: object, sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence.replace("(", r"\(")):
        make()  # type: ignore[operator]


def test_every_component_of_the_balls_has_a_representative() -> None:
    two = np.vstack([XYZ, XYZ + np.array([5, 0, 0])])
    cloud = Points(two, 0.4)
    assert sorted((cloud.representatives[:, 0] > 3).tolist()) == [False, True]


def test_blocks_and_regions_hold_each_sample_once_and_blocks_stay_the_same() -> None:
    cloud = Points(XYZ, 0.01)
    blocks = split_blocks(Obstacle("cam", cloud, np.eye(4)))
    assert sum(len(item.shape.vertices) for item in blocks) == 60  # type: ignore[union-attr]
    moved = Points(np.vstack([XYZ, [[9.0, 9.0, 9.0]]]), 0.01)
    again = split_blocks(Obstacle("cam", moved, np.eye(4)), blocks)
    assert [item for item in again if item not in blocks] == again[-1:]
    rest, part = split_regions("a", cloud, np.eye(4), {"b": (0, 0, 0, 0.5, 1, 1)})
    assert (part.shape.vertices[:, 0] <= 0.5).all()  # type: ignore[union-attr]
    assert (rest.shape.vertices[:, 0] > 0.5).all()  # type: ignore[union-attr]


@pytest.mark.parametrize("unknown", ["solid", "solid everywhere", "free"])
@pytest.mark.parametrize("seed", range(4))
def test_a_cell_is_free_only_where_every_pixel_over_it_ended_behind_it(unknown: str, seed: int) -> None:
    """Against points in the cells: the four pixels around a point of a free cell have seen farther than the point."""
    rng = np.random.default_rng(seed)
    height, width = int(rng.integers(20, 60)), int(rng.integers(20, 90))
    depth = np.where(rng.random((height, width)) < 0.01, 0.0, 1.0)
    depth[5:12, 8:15], depth[-4:, -8:] = 0.5, 7.0  # something nearer, and nothing
    fx, fy, cx, cy = rng.uniform(20, 90), rng.uniform(20, 90), rng.uniform(0, width), rng.uniform(0, height)
    image = DepthImage(depth, (fx, fy, cx, cy), np.eye(4), (0.1, 1.5), pitch=0.06, unknown=unknown)  # type: ignore[arg-type]
    surface = image.surface()
    assert surface is not None
    shown = image.positions(depth)[(depth > 0) & (depth < 1.5)]
    assert max(np.linalg.norm(surface.vertices - point, axis=1).min() for point in shown[::37]) <= surface.radius
    assert [item.name for item in image.obstacles("c")] == ["c", "c_unknown"][: 1 + (unknown != "free")]
    if unknown == "free" or (space := image.unknown_space()) is None:
        return
    padded = np.pad(image.depth, 1, constant_values=0.0 if unknown == "solid everywhere" else np.inf)
    cells = np.argwhere(np.ones(space.occupied.shape, dtype=bool))[rng.permutation(space.occupied.size)[:4000]]
    solid, low = space.occupied[tuple(cells.T)], space.origin + space.pitch * cells

    def pixels(point: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        z = np.where(point[:, 2] > 1e-9, point[:, 2], np.nan)
        column, row = fx * point[:, 0] / z + cx, fy * point[:, 1] / z + cy
        inside = (column > -1) & (column < width) & (row > -1) & (row < height)
        return inside, *(np.where(inside, np.floor(each), 0).astype(int) + 1 for each in (row, column))

    for _ in range(10):
        point = low + space.pitch * rng.random((len(cells), 3))
        inside, row, column = pixels(point)
        least = np.min([padded[row + i, column + k] for i in (0, 1) for k in (0, 1)], axis=0)
        assert (solid | ~inside | (least >= point[:, 2])).all()
    inside, row, column = pixels(low + 0.5 * space.pitch)
    for k in np.flatnonzero(solid & inside & (low[:, 2] > 0.6)):  # something nearer is seen within a few pixels
        near = padded[max(row[k] - 14, 0) : row[k] + 15, max(column[k] - 14, 0) : column[k] + 15]
        assert near.min() < low[k, 2] + space.pitch
    if unknown == "solid":
        assert not solid[low[:, 2] < -1e-9].any()


def point_cloud_bag(xyz: np.ndarray) -> bytes:
    """An MCAP file with a PointCloud2 whose fields stand in another order, with padding between rows and points."""
    file = io.BytesIO()
    writer = Writer(file)
    schema = writer.register_msgdef("sensor_msgs/msg/PointCloud2", POINT_CLOUD)
    layout = np.dtype({"names": ["z", "x", "y"], "formats": ["<f4"] * 3, "offsets": [8, 0, 4], "itemsize": 16})
    points = np.zeros(len(xyz), dtype=layout)
    for k, name in enumerate("xyz"):
        points[name] = xyz[:, k]
    rows = points.view(np.uint8).reshape(2, -1)
    rows = np.hstack([rows, np.full((2, 5), 7, dtype=np.uint8)])
    fields = [{"name": name, "offset": 4 * k, "datatype": 7, "count": 1} for k, name in enumerate("xyz")]
    message = {"header": {}, "height": 2, "width": len(xyz) // 2, "fields": fields, "is_bigendian": False}
    message |= {"point_step": 16, "row_step": rows.shape[1], "data": rows.tobytes(), "is_dense": True}
    writer.write_message("/points", schema, message, 0, 0, 0)
    writer.finish()
    return file.getvalue()


def test_points_survive_every_file_format(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", XYZ)
    np.savez(tmp_path / "a.npz", xyz=XYZ)
    np.savetxt(tmp_path / "a.xyz", XYZ)
    trimesh.PointCloud(XYZ).export(tmp_path / "a.ply")
    PointCloud.from_xyz_points(XYZ.astype(np.float32)).save(tmp_path / "a.pcd")
    (tmp_path / "a.mcap").write_bytes(point_cloud_bag(XYZ))
    for ending in ("npy", "npz", "xyz", "ply", "pcd", "mcap"):
        np.testing.assert_allclose(read_points(tmp_path / f"a.{ending}", 2.0), 2.0 * XYZ, atol=1e-6)


def test_depths_and_voxels_survive_their_files(tmp_path: Path) -> None:
    millimetres = RNG.integers(0, 5000, (20, 30)).astype(np.uint16)
    Image.fromarray(millimetres).save(tmp_path / "d.png")
    np.testing.assert_allclose(read_depth(tmp_path / "d.png"), millimetres / 1000)
    solid = RNG.random((3, 4, 5)) < 0.5
    np.savez(tmp_path / "v.npz", occupied=solid, pitch=0.1, origin=np.ones(3))
    voxels = read_voxels(tmp_path / "v.npz")
    assert (voxels.occupied == solid).all()
    assert voxels.pitch == 0.1


@pytest.mark.parametrize("reader", [read_points, read_voxels, read_depth])
def test_a_file_that_cannot_be_read_is_named(reader: object, tmp_path: Path) -> None:
    for name, content in {"a.ply": b"ply", "a.npz": b"x", "a.png": b"", "a.npy": b"y", "a.zip": b""}.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(PlannerError, match=name):
            reader(tmp_path / name)  # type: ignore[operator]


def test_a_scene_file_holds_clouds_with_their_pose(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", XYZ)
    Image.fromarray(np.full((24, 32), 900, dtype=np.uint16)).save(tmp_path / "d.png")
    posed = "position: [0, 0, 1]"
    (tmp_path / "s.yaml").write_text(
        f"obstacles:\n  - {{name: a, type: points, file: a.npy, radius: 0.01, noise: 0.002, {posed}, "
        "regions: {b: [0, 0, 0, 0.5, 1, 1]}}\n"
        f"  - {{name: c, type: depth, file: d.png, intrinsics: [30, 30, 16, 12], {posed}}}\n"
    )
    scene = Scene.load(tmp_path / "s.yaml")
    assert [item.name for item in scene.obstacles] == ["a", "b", "c", "c_unknown"]
    assert scene.obstacles[0].placement[2, 3] == 1.0
    assert any("'a' is solid within 12 mm" in note.text for note in scene.notes)
    (tmp_path / "t.yaml").write_text("obstacles:\n  - {name: a, type: points, file: a.npy}\n")
    with pytest.raises(SceneError, match="give the pose of the sensor"):
        Scene.load(tmp_path / "t.yaml")


def test_an_octomap_of_a_moveit_scene_is_solid_where_its_tree_says_so(tmp_path: Path) -> None:
    pyoctomap = pytest.importorskip("pyoctomap")
    tree, cells = pyoctomap.OcTree(0.1), np.unique(RNG.integers(-3, 4, (30, 3)), axis=0)
    for cell in cells:
        tree.updateNode(0.1 * (cell + 0.5), True)
    for binary, write in ((True, tree.writeBinary), (False, tree.write)):
        write(str(tmp_path / "tree"))
        content = (tmp_path / "tree").read_bytes().partition(b"data\n")[2]
        voxels = decode_octomap(content, 0.1, binary, "OcTree")
        assert voxels is not None
        solid = np.argwhere(voxels.occupied) + np.rint(voxels.origin / voxels.pitch).astype(int)
        assert {tuple(row) for row in solid} == {tuple(row) for row in cells}
        for broken in (content[:-1], content[:-2], content[: len(content) // 2], b""):
            with pytest.raises(ValueError, match="not whole"):
                decode_octomap(broken, 0.1, binary, "OcTree")


def test_plan_json_holds_the_terms_of_the_radius(tmp_path: Path) -> None:
    far = Points(XYZ + np.array([0.0, 0.0, 3.0]), 0.01, noise=0.002)
    scene = Scene("s", (Obstacle("cloud", far, np.eye(4)),))
    plan = planner.plan("planar_2r", scene, start="q:0,1", goal="q:1,1", path_only=True, timing=None)
    plan.save(tmp_path)
    (cloud,) = json.loads((tmp_path / "plan.json").read_text())["clouds"]
    assert (cloud["obstacle"], cloud["points"], cloud["estimated"]) == ("cloud", 60, False)
    assert (cloud["covering"], cloud["noise"], cloud["calibration"], cloud["radius"]) == (0.01, 0.002, 0.0, 0.012)
