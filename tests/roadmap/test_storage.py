"""Roadmaps on disk: the same bytes, and one kind of refusal for whatever is not a roadmap of ours."""

import fcntl
import io
import json
import os
import subprocess
import sys
import zipfile
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.base.errors import FileError, PlannerError
from planner.base.hashing import content_hash
from planner.collision import make_checker
from planner.construction.connect_endpoints import attach
from planner.models.poses import pose
from planner.models.robot import Robot
from planner.models.shapes import Box
from planner.planning.network import build_network
from planner.roadmap import storage
from planner.roadmap.roadmap import DTYPES
from planner.roadmap.storage import load_roadmap, require_same_world, save_roadmap
from tests.random_shapes import QUICK
from tests.worlds import checker_of, load, make_post, post_roadmap, scene_of

ROADMAP = post_roadmap(30)
ARRAYS = tuple(DTYPES)


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("roadmap") / "roadmap.npz"
    save_roadmap(ROADMAP, path)
    return path.read_bytes()


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("damaged")


def test_round_trip(content, tmp_path):
    (tmp_path / "a.npz").write_bytes(content)
    back = load_roadmap(tmp_path / "a.npz")
    for name in ARRAYS:
        ours, theirs = getattr(back, name), getattr(ROADMAP, name)
        np.testing.assert_array_equal(ours, theirs)
        assert ours.dtype == theirs.dtype
        assert not ours.flags.writeable
    assert back.scale == ROADMAP.scale
    assert back.origin == ROADMAP.origin
    assert back.sha256 == ROADMAP.sha256


def test_the_same_roadmap_is_the_same_bytes(content, tmp_path):
    save_roadmap(ROADMAP, tmp_path / "b.npz")
    assert (tmp_path / "b.npz").read_bytes() == content
    save_roadmap(load_roadmap(tmp_path / "b.npz"), tmp_path / "c.npz")
    assert (tmp_path / "c.npz").read_bytes() == content
    assert sorted(os.listdir(tmp_path)) == ["b.npz", "c.npz"]


def test_no_pickle_is_written(content):
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert archive.testzip() is None
        for item in archive.namelist():
            assert b"'O'" not in archive.read(item)[:200]


def test_only_what_compresses_is_compressed_and_a_file_compressed_as_a_whole_reads_the_same(content, tmp_path):
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        stored = {item.filename[:-4] for item in archive.infolist() if item.compress_type == zipfile.ZIP_STORED}
    assert stored == {name for name, dtype in DTYPES.items() if dtype is np.float64}
    assert load_roadmap(rewritten(content, tmp_path / "packed.npz")).sha256 == ROADMAP.sha256
    assert (tmp_path / "packed.npz").stat().st_size < len(content)


def test_a_file_is_readable_by_others(tmp_path):
    save_roadmap(ROADMAP, tmp_path / "a.npz")
    mask = os.umask(0)
    os.umask(mask)
    assert (tmp_path / "a.npz").stat().st_mode & 0o777 == 0o666 & ~mask


# writing that fails


def test_a_failing_write_leaves_the_old_file_and_nothing_else(content, tmp_path, monkeypatch):
    path = tmp_path / "roadmap.npz"
    path.write_bytes(content)

    def full(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("planner.base.files.os.fsync", full)
    with pytest.raises(FileError, match=r"roadmap\.npz cannot be written: No space left on device; choose another"):
        save_roadmap(post_roadmap(30, seed=1), path)
    assert path.read_bytes() == content
    assert os.listdir(tmp_path) == ["roadmap.npz"]


def test_a_folder_that_is_not_there_or_a_folder_in_its_place(tmp_path):
    with pytest.raises(FileError, match="cannot be written: No such file or directory"):
        save_roadmap(ROADMAP, tmp_path / "no" / "roadmap.npz")
    (tmp_path / "roadmap.npz").mkdir()
    with pytest.raises(FileError, match="cannot be written: Is a directory"):
        save_roadmap(ROADMAP, tmp_path / "roadmap.npz")
    assert os.listdir(tmp_path) == ["roadmap.npz"]


# writers that are killed

KILL = """
import os, random, signal, sys, time
from pathlib import Path
from planner.roadmap.storage import load_roadmap, save_roadmap

path, spare = Path(sys.argv[1]), Path(sys.argv[2])
roadmaps = load_roadmap(path), load_roadmap(spare)
whole = {roadmap.sha256 for roadmap in roadmaps}
draw = random.Random(0)
for _ in range(25):
    child = os.fork()
    if child == 0:
        while True:
            for roadmap in roadmaps:
                save_roadmap(roadmap, path)
    time.sleep(draw.uniform(0.001, 0.04))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    found = load_roadmap(path).sha256
    print(found in whole, len(list(path.parent.glob(".*"))), flush=True)
"""


def test_a_kill_at_any_moment_leaves_a_whole_file_and_little_litter(content, tmp_path):
    path = tmp_path / "kept" / "roadmap.npz"
    path.parent.mkdir()
    path.write_bytes(content)
    save_roadmap(post_roadmap(30, seed=1), tmp_path / "spare.npz")
    process = subprocess.run(
        [sys.executable, "-c", KILL, str(path), str(tmp_path / "spare.npz")],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert process.returncode == 0, process.stderr
    lines = [line.split() for line in process.stdout.splitlines()]
    assert len(lines) == 25
    assert {whole for whole, _ in lines} == {"True"}
    assert max(int(litter) for _, litter in lines) <= 1
    save_roadmap(ROADMAP, path)
    assert os.listdir(path.parent) == ["roadmap.npz"]


def test_only_litter_is_cleared(tmp_path):
    """What a living writer holds, and what is no temporary file of this name, stays."""
    names = [".roadmap.npz.abcd1234.unfinished", ".roadmap.npz.backup", ".other.npz.abcd1234.unfinished", "notes"]
    for name in names:
        (tmp_path / name).write_text(name)
    with (tmp_path / ".roadmap.npz.wxyz1234.unfinished").open("wb") as living:
        fcntl.flock(living, fcntl.LOCK_EX)
        save_roadmap(ROADMAP, tmp_path / "roadmap.npz")
        assert sorted(os.listdir(tmp_path)) == sorted([*names[1:], ".roadmap.npz.wxyz1234.unfinished", "roadmap.npz"])
    save_roadmap(ROADMAP, tmp_path / "roadmap.npz")
    assert sorted(os.listdir(tmp_path)) == sorted([*names[1:], "roadmap.npz"])


def test_where_files_cannot_be_locked(tmp_path, monkeypatch):
    def unable(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr("planner.base.files.fcntl.flock", unable)
    (tmp_path / ".roadmap.npz.abcd1234.unfinished").write_text("perhaps alive")
    save_roadmap(ROADMAP, tmp_path / "roadmap.npz")
    assert sorted(os.listdir(tmp_path)) == [".roadmap.npz.abcd1234.unfinished", "roadmap.npz"]
    assert load_roadmap(tmp_path / "roadmap.npz").sha256 == ROADMAP.sha256


# damage


def refused(path: Path) -> str:
    with pytest.raises(FileError) as caught:
        load_roadmap(path)
    message = str(caught.value)
    assert str(path) in message
    assert message.endswith(".")
    assert "\n" not in message
    assert type(caught.value.__cause__) is type(None)
    return message


def harmless_or_refused(path: Path) -> bool:
    """True where the file is refused; a file that loads must be the roadmap to the last bit."""
    try:
        back = load_roadmap(path)
    except FileError:
        return True
    assert back.sha256 == ROADMAP.sha256
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(back, name), getattr(ROADMAP, name))
    assert back.scale == ROADMAP.scale
    return False


@QUICK
@given(st.data())
def test_flipped_bytes(content, folder, data):
    damaged = bytearray(content)
    places = st.lists(st.integers(0, len(content) - 1), min_size=1, max_size=4)
    for place in data.draw(places):
        damaged[place] ^= data.draw(st.integers(1, 255))
    (folder / "a.npz").write_bytes(damaged)
    harmless_or_refused(folder / "a.npz")


def sweep(content: bytes, folder: Path, places: range, flips: tuple[int, ...]) -> dict[str, int]:
    """Every one of these bytes flipped, one at a time: how often which exception other than FileError came out."""
    path, others = folder / "b.npz", {}
    for place in places:
        for flip in flips:
            damaged = bytearray(content)
            damaged[place] ^= flip
            path.write_bytes(damaged)
            try:
                harmless_or_refused(path)
            except Exception as error:
                others[type(error).__name__] = others.get(type(error).__name__, 0) + 1
    return others


def test_every_byte_of_the_first_header(content, folder):
    assert sweep(content, folder, range(0, 120), (0x01, 0x08, 0xFF)) == {}


def test_every_byte_of_the_directory(content, folder):
    """Where flags say encrypted, or name a compression that is not there."""
    start = content.index(b"PK\x01\x02")
    assert sweep(content, folder, range(start, min(len(content), start + 140)), (0x01, 0x08, 0xFF)) == {}


def test_some_byte_of_everything(content, folder):
    assert sweep(content, folder, range(0, len(content), 23), (0x10,)) == {}


@QUICK
@given(st.floats(0, 1, exclude_max=True))
def test_truncated(content, folder, share):
    (folder / "c.npz").write_bytes(content[: int(share * len(content))])
    refused(folder / "c.npz")


@QUICK
@given(st.binary(max_size=300), st.booleans())
def test_noise(content, folder, noise, zipped):
    (folder / "d.npz").write_bytes((b"PK\x03\x04" if zipped else b"") + noise)
    refused(folder / "d.npz")


@QUICK
@given(st.data())
def test_cut_and_pasted(content, folder, data):
    a, b = sorted(data.draw(st.tuples(*[st.integers(0, len(content))] * 2)))
    (folder / "e.npz").write_bytes(content[:a] + content[b:])
    if a != b:
        harmless_or_refused(folder / "e.npz")


# hostile: whole zips whose content is not what it should be


def rewritten(content: bytes, path: Path, header=None, arrays=None, raw=None, forged=False) -> Path:
    """The file with its header mapped by ``header``, ``arrays`` replaced (None: left out), ``raw`` members put in.

    A forger knows how the hashes are made, and names the right ones.
    """
    with np.load(io.BytesIO(content)) as old:
        data = {name: old[name] for name in old.files}
    data |= arrays or {}
    text: Any = json.loads(str(data["header"])) if data["header"] is not None and data["header"].ndim == 0 else None
    text = header(text) if header is not None else text
    if forged:
        kept = replace(ROADMAP, **{name: data[name] for name in DTYPES})
        text |= {"sha256": kept.sha256}
        text["checksum"] = storage._checksum(text, data)
    if text is not None:
        data["header"] = np.array(text if isinstance(text, str) else json.dumps(text))
    data = {name: value for name, value in data.items() if value is not None}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **data)
    with zipfile.ZipFile(buffer) as archive:
        members = {name: archive.read(name) for name in archive.namelist()} | (raw or {})
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, value in members.items():
            archive.writestr(name, value)
    return path


def but(*keys, **changes):
    """A header with ``changes`` at the place that ``keys`` lead to; ... takes a key away."""

    def apply(header):
        place = header
        for key in keys:
            place = place[key]
        for key, value in changes.items():
            if value is ...:
                del place[key]
            else:
                place[key] = value
        return header

    return apply


def npy(shape, data: bytes) -> bytes:
    """An array file that says it has ``shape``, whatever ``data`` it has."""
    buffer = io.BytesIO()
    np.lib.format.write_array_header_1_0(buffer, {"shape": shape, "fortran_order": False, "descr": "<f8"})
    return buffer.getvalue() + data


ROADMAP_WORLD = asdict(ROADMAP.origin.world)
W = ROADMAP.edge_manipulability
NODES, EDGES = np.array(ROADMAP.nodes), np.array(ROADMAP.edges)
HOSTILE = {
    "no header": ({"arrays": {"header": None}}, "header"),
    "header is no text": ({"header": lambda h: "{"}, "Expecting property name"),
    "header is a list": ({"header": lambda h: [1]}, "not a roadmap of this planner"),
    "another format": ({"header": but(format="other")}, "not a roadmap of this planner"),
    "the version before": ({"header": but(version=1)}, "format version 1, this planner reads 3: build it again"),
    "a version to come": ({"header": but(version=4)}, "format version 4, this planner reads 3"),
    "a version that is no number": ({"header": but(version=[3])}, "format version [3]"),
    "no hash of everything": ({"header": but(checksum=...)}, "checksum"),
    "another hash of everything": ({"header": but(checksum="0" * 64)}, "does not match its hash"),
    "a smaller margin": ({"header": but("origin", margin=1e-9)}, "does not match its hash"),
    "another scale": ({"header": but("scale", w_low=1e-9)}, "does not match its hash"),
    "another scene": ({"header": but("origin", scene_identity="0" * 64)}, "does not match its hash"),
    "no world": ({"header": but("origin", world=...)}, "world"),
    "a world of nothing": ({"header": but("origin", world={})}, "world"),
    "a world of too much": ({"header": but("origin", "world", extra=1)}, "extra"),
    "a body that is a number": ({"header": but("origin", "world", bodies=[1])}, "bodies"),
    "a body of too few words": ({"header": but("origin", "world", bodies=[{"name": "a"}])}, "bodies"),
    "obstacles that are text": ({"header": but("origin", "world", obstacles="none")}, "obstacles"),
    "limits that are NaN": ({"header": but("origin", "world", lower=[float("nan")] * 2)}, "damaged"),
    "limits of another count": ({"header": but("origin", "world", lower=[0.0])}, "2 joints and limits of 1"),
    "pairs of bodies that are not there": (
        {"header": but("origin", "world", self_pairs=[[0, 99]])},
        "bodies that are not there",
    ),
    "a pair of three": ({"header": but("origin", "world", self_pairs=[[0, 1, 2]])}, "self_pairs"),
    "a pair of negative bodies": ({"header": but("origin", "world", self_pairs=[[-1, 0]])}, "bodies that are not"),
    "no origin": ({"header": but(origin=...)}, "origin"),
    "origin is a number": ({"header": but(origin=3)}, "damaged"),
    "a key of the origin is missing": ({"header": but("origin", tool=...)}, "tool"),
    "a key too much": ({"header": but("origin", extra=1)}, "extra"),
    "a margin below nothing": ({"header": but("origin", margin=-1.0)}, "margin is negative"),
    "a key of the scale is missing": ({"header": but("scale", zeta=...)}, "zeta"),
    "another hash": ({"header": but(sha256="0" * 64)}, "does not match its hash"),
    "another tool": ({"header": but("origin", tool="x")}, "does not match its hash"),
    "joints of another count": ({"header": but("origin", joints=["a"])}, "1 joints and limits of 2"),
    "another robot": (
        {"header": but("origin", joints=["a"], world=dict(ROADMAP_WORLD, lower=[0.0], upper=[1.0]))},
        "array 'nodes' has shape",
    ),
    "an array is missing": ({"arrays": {"edges": None}}, "it lacks edges"),
    "an array too many": ({"arrays": {"more": NODES}}, "it holds more too"),
    "no certificates": ({"arrays": {"clearance": None, "samples": None}}, "it lacks clearance, samples"),
    "a clearance that is NaN": ({"arrays": {"clearance": ROADMAP.clearance * np.nan}}, "not finite"),
    "a clearance below nothing": ({"arrays": {"clearance": ROADMAP.clearance - 1}}, "negative"),
    "a clearance for every node": ({"arrays": {"clearance": NODES[:, 0]}}, "array 'clearance' has shape"),
    "clearances in rows": ({"arrays": {"clearance": ROADMAP.clearance[:, None]}}, "array 'clearance' has shape"),
    "a clearance moved": ({"arrays": {"clearance": ROADMAP.clearance + 1e-9}}, "does not match its hash"),
    "samples that are no integers": ({"arrays": {"samples": ROADMAP.samples + 0.5}}, "array 'samples'"),
    "samples below nothing": ({"arrays": {"samples": -1 - ROADMAP.samples}}, "negative"),
    "fewer samples than edges": ({"arrays": {"samples": ROADMAP.samples[:-1]}}, "array 'samples' has shape"),
    "proofs that are numbers": ({"arrays": {"proven": ROADMAP.proven.astype(float)}}, "array 'proven'"),
    "half a node": ({"arrays": {"edges": EDGES.astype(float)}}, "array 'edges'"),
    "single precision": ({"arrays": {"nodes": NODES.astype(np.float32)}}, "array 'nodes'"),
    "edges out of order": ({"arrays": {"edges": EDGES[::-1]}}, "not in order"),
    "an edge twice": ({"arrays": {"edges": np.vstack([EDGES[:1], EDGES[:-1]])}}, "not in order"),
    "no w along edges": ({"arrays": {"edge_manipulability": None}}, "it lacks edge_manipulability"),
    "w along an edge that is NaN": ({"arrays": {"edge_manipulability": W * np.nan}}, "not finite"),
    "w along an edge below nothing": ({"arrays": {"edge_manipulability": -1 - W}}, "negative"),
    "w at too few states": ({"arrays": {"edge_manipulability": W[:, 1:]}}, "array 'edge_manipulability' has shape"),
    "w below nothing": ({"arrays": {"manipulability": -1 - ROADMAP.manipulability}}, "negative"),
    "a node moved": ({"arrays": {"nodes": NODES + 1e-9}}, "does not match its hash"),
    "a node that is NaN": ({"arrays": {"nodes": NODES * np.nan}}, "not finite"),
    "a node beyond any arm": ({"arrays": {"nodes": NODES * 1e12}}, "holds values beyond 1e"),
    "a library that is none": ({"arrays": {"checked_by": ROADMAP.checked_by + np.int8(7)}}, "names libraries that"),
    "nodes in one row": ({"arrays": {"nodes": NODES.ravel()}}, "array 'nodes' has shape"),
    "text for nodes": ({"arrays": {"nodes": NODES.astype(str)}}, "array 'nodes'"),
    "complex nodes": ({"arrays": {"nodes": NODES.astype(complex)}}, "array 'nodes'"),
    "pickled nodes": ({"arrays": {"nodes": NODES.astype(object)}}, "allow_pickle=False"),
    "a header of another kind": ({"arrays": {"header": NODES}}, "damaged"),
    "a pickle more": ({"raw": {"header.npy": b"\x80\x04K\x01."}}, "damaged"),
    "an edge to nowhere": ({"arrays": {"edges": EDGES + 10_000}}, "nodes that are not there"),
    "an edge to a negative node": ({"arrays": {"edges": EDGES - 10_000}}, "nodes that are not there"),
    "an edge the wrong way round": ({"arrays": {"edges": EDGES[:, ::-1]}}, "lower node first"),
    "an edge from a node to itself": ({"arrays": {"edges": EDGES * 0}}, "lower node first"),
    "fewer proofs than edges": ({"arrays": {"proven": ROADMAP.proven[:-1]}}, "array 'proven' has shape"),
    "a start that is not there": ({"arrays": {"starts": np.array([99])}}, "nodes that are not there"),
    "starts in two rows": ({"arrays": {"starts": np.array([[0], [1]])}}, "array 'starts' has shape"),
    "nodes without a shape": ({"arrays": {"nodes": np.array(1.0)}}, "damaged"),
    "more nodes than bytes": ({"raw": {"nodes.npy": npy((10**12, 2), b"")}}, "does not fit its size"),
    "fewer nodes than bytes": ({"raw": {"nodes.npy": npy((1, 2), bytes(48))}}, "does not fit its size"),
    "a negative number of nodes": ({"raw": {"nodes.npy": npy((-1, 2), b"")}}, "does not fit its size"),
    "an overflowing number of nodes": ({"raw": {"nodes.npy": npy((2**62, 2**62), b"")}}, "does not fit its size"),
    "w that is infinite": ({"arrays": {"manipulability": ROADMAP.manipulability * np.inf}}, "not finite"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile(content, tmp_path, case):
    change, part = HOSTILE[case]
    assert part in refused(rewritten(content, tmp_path / "x.npz", **change))


# no header, or no arrays that a hash could be taken over
NO_HASH = {
    *("no header", "header is no text", "header is a list", "a header of another kind"),
    *("an array is missing", "no certificates", "complex nodes"),
}
FORGED = [
    case
    for case, (change, part) in HOSTILE.items()
    if "hash" not in part + case and "raw" not in change and case not in NO_HASH
]


@pytest.mark.parametrize("case", FORGED)
def test_a_forger_who_names_the_right_hashes_is_refused_as_well(content, tmp_path, case):
    change, _ = HOSTILE[case]
    refused(rewritten(content, tmp_path / "x.npz", **change, forged=True))


def test_a_forger_can_name_the_right_hashes(content, tmp_path):
    """So a hash is no signature: a lie within bounds loads, and is for planner.construction.repair.verify to find."""
    path = rewritten(content, tmp_path / "x.npz", arrays={"clearance": ROADMAP.clearance + 1.0}, forged=True)
    np.testing.assert_array_equal(load_roadmap(path).clearance, ROADMAP.clearance + 1.0)


NO_NODES = {name: getattr(ROADMAP, name)[:0] for name in ARRAYS}


@pytest.mark.parametrize(
    "change",
    [
        {"header": but(sha256=...)},
        {"header": lambda h: "[" * 100_000},
        {"raw": {"starts.npy": b"hello"}},
        {"arrays": NO_NODES},
    ],
    ids=["no hash", "deep header", "bytes for an array", "no nodes"],
)
def test_hostile_too(content, tmp_path, change):
    message = refused(rewritten(content, tmp_path / "x.npz", **change))
    assert "does not match its hash" not in message


@pytest.mark.parametrize(
    "header",
    [
        but("origin", margin="wide"),
        but("origin", margin=float("nan")),
        but("scale", w_low="x"),
        but("scale", zeta=None),
        but("scale", zeta=float("nan")),
        but("scale", joint_length=0),
        but("scale", joint_length=-1),
    ],
    ids=["margin text", "margin nan", "w_low text", "zeta none", "zeta nan", "length 0", "length negative"],
)
def test_header_numbers_are_numbers(content, tmp_path, header):
    refused(rewritten(content, tmp_path / "x.npz", header=header))


def test_a_zip_that_unpacks_to_far_too_much(content, tmp_path, monkeypatch):
    monkeypatch.setattr("planner.roadmap.storage._LARGEST", 1000)
    (tmp_path / "a.npz").write_bytes(content)
    assert "would unpack to" in refused(tmp_path / "a.npz")


def test_a_zip_bomb(content, tmp_path):
    """50 MB of zeros in 50 kB: refused by what it would unpack to, before any of it is."""
    zeros = npy((3_000_000, 2), bytes(48_000_000))
    path = rewritten(content, tmp_path / "a.npz", raw={"nodes.npy": zeros})
    assert path.stat().st_size < 100_000
    assert "would unpack to 48" in refused(path)
    path = rewritten(content, tmp_path / "b.npz", raw={"bomb.npy": zeros})
    assert "would unpack to 48" in refused(path)


def test_a_header_of_far_too_much(content, tmp_path, monkeypatch):
    monkeypatch.setattr("planner.roadmap.storage._LARGEST_HEADER", 1000)
    (tmp_path / "a.npz").write_bytes(content)
    assert "its header has" in refused(tmp_path / "a.npz")


def test_nothing_to_touch_is_no_damage(tmp_path):
    free = replace(ROADMAP, clearance=np.full(len(EDGES), np.inf))
    save_roadmap(free, tmp_path / "a.npz")
    assert np.isinf(load_roadmap(tmp_path / "a.npz").clearance).all()


def test_other_files(tmp_path):
    assert "not found: 'planner roadmap build' makes one" in refused(tmp_path / "none.npz")
    assert "is a folder" in refused(tmp_path)
    for name, data in (("empty.npz", b""), ("text.npz", b"hello"), ("pickle.npz", b"\x80\x04K\x01.")):
        (tmp_path / name).write_bytes(data)
        assert "damaged or no roadmap" in refused(tmp_path / name)
    np.save(tmp_path / "one.npy", np.zeros(3))
    assert "damaged or no roadmap" in refused(tmp_path / "one.npy")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    assert "damaged or no roadmap" in refused(tmp_path / "other.npz")


# whose roadmap it is


def test_its_own_world_is_accepted():
    require_same_world(ROADMAP, make_post(), Path("r.npz"))


def other_worlds():
    robot = load("planar_2r")
    post = [(Box((0.1, 0.02, 0.2)), pose([0.75, 0, 0]))]
    moved = [(Box((0.1, 0.02, 0.2)), pose([0.76, 0, 0]))]
    renamed = replace(scene_of(*post), name="corner")
    raised = Robot.load("planar_2r", base=pose([0, 0, 0.1]))
    return {
        "robot": (checker_of("iiwa14"), ["is for robot 'planar_2r', not 'iiwa14'", "build one for this robot"]),
        "tool": (
            make_checker(Robot.load("planar_2r", tool="link_2"), scene_of(*post)),
            ["is for tool frame 'tool', not 'link_2'"],
        ),
        "scene": (make_checker(robot, renamed), ["is for scene 'made', not 'corner'"]),
        "obstacles": (make_checker(robot, scene_of(*moved)), ["scene 'made' with other obstacles", "build it again"]),
        "set-up": (make_checker(raised, scene_of(*post)), ["'planar_2r' of other geometry or set-up"]),
        "margin": (
            make_checker(robot, scene_of(*post), margin=0.01),
            ["proven with a margin of 0 m, less than the 0.01 m asked for", "ask for less"],
        ),
    }


@pytest.mark.parametrize("case", ["robot", "tool", "scene", "obstacles", "set-up", "margin"])
def test_foreign(case):
    checker, parts = other_worlds()[case]
    with pytest.raises(FileError) as caught:
        require_same_world(ROADMAP, checker, Path("r.npz"))
    assert [part for part in ["r.npz", *parts] if part not in str(caught.value)] == []
    assert isinstance(caught.value, PlannerError)


def test_a_larger_margin_serves_a_smaller_one():
    careful = replace(ROADMAP, origin=replace(ROADMAP.origin, margin=0.02))
    require_same_world(careful, make_post(), Path("r.npz"))


def test_a_loaded_roadmap_is_of_use(content, tmp_path):
    (tmp_path / "a.npz").write_bytes(content)
    back = attach(load_roadmap(tmp_path / "a.npz"), make_post(), np.array([[-0.9, 1.2]]), ROADMAP.nodes[ROADMAP.goals])
    assert build_network(back).n_nodes > len(ROADMAP.nodes)


def test_a_file_of_version_2_is_read_and_nobody_has_checked_its_nodes(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """It lacks ``checked_by`` and ``edge_cost``, and its checksum leaves them out."""
    kept = post_roadmap(seed=1)
    save_roadmap(kept, tmp_path / "new.npz")
    with np.load(tmp_path / "new.npz") as content:
        arrays = {name: content[name] for name in content.files if name not in ("header", "checked_by", "edge_cost")}
        header = json.loads(str(content["header"])) | {"version": 2}
    del header["checksum"]
    header["checksum"] = content_hash(
        [json.dumps(header, sort_keys=True), *(arrays[name] for name in DTYPES if name in arrays)]
    )
    np.savez(tmp_path / "old.npz", header=np.array(json.dumps(header, sort_keys=True)), **arrays)
    old = load_roadmap(tmp_path / "old.npz")
    assert old.sha256 == kept.sha256
    assert not old.checked_by.any()
    np.testing.assert_allclose(old.edge_cost, kept.edge_cost, rtol=0.2)
    assert (old.edge_cost != kept.edge_cost).any()
    assert "'planner roadmap check --repair' measures it finer" in caplog.text
    assert load_roadmap(tmp_path / "new.npz").checked_by.all()
