"""Networks on disk: ``.npz`` files whose arrays a network uses where they lie, without a copy in memory."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np

from planner.base.errors import FileError, PlannerError
from planner.base.files import whole_file
from planner.base.npz import DAMAGE, array_header, require_sane_sizes
from planner.base.places import Place, place
from planner.gabf.kernels import Kernel
from planner.gabf.network import Network

_ARRAYS = ("indptr", "indices", "weight", "sources", "source_values", "node_cost", "arc_cost")
_REQUIRED = frozenset(("indptr", "indices", "weight", "sources"))
_ALIGNED = 64  # bytes: where an array begins, so that it is used as quickly as one in memory
_LOCAL_HEADER, _ZIP64_EXTRA = 30, 20  # bytes of a zip member's header, and of what it says of sizes beyond 4 GiB
_PADDING = 0x4150  # the id of a part of a header that readers pass over
_MAP_FROM = 4096  # bytes; smaller arrays are read
_SLACK = 64 << 20  # bytes


def write_network(network: Network, path: Place) -> None:
    """Write the arrays of ``network``, uncompressed and aligned, whole or not at all; its kernel is not kept.

    Any reader of ``.npz`` reads the file. :class:`FileError` where it cannot be written.
    """
    with (
        whole_file(place(path), lasting=False) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_STORED, allowZip64=True) as archive,
    ):
        for name in _ARRAYS:
            if (array := getattr(network, name)) is not None:
                _write_member(archive, file, f"{name}.npy", array)


def read_network(path: Place, kernel: Kernel) -> Network:
    """The network in ``path`` under ``kernel``, its arrays mapped read-only into memory where they are not compressed.

    Pages are loaded as they are used, and processes of one machine share them. Raises :class:`FileError` for a file
    that is none of a network, AssumptionError as :class:`Network` does.
    """
    path = place(path)
    try:
        require_sane_sizes(path, f"network {path}", _SLACK)
        with zipfile.ZipFile(path) as archive, path.open("rb") as file:
            members = {Path(info.filename).stem: info for info in archive.infolist()}
            arrays = {name: _read_member(archive, file, members[name]) for name in _ARRAYS if name in members}
    except DAMAGE as error:
        raise FileError(f"network {path} cannot be read: {error}; give a .npz file of a network.") from None
    missing = _REQUIRED - arrays.keys()
    if missing:
        raise FileError(f"network {path} lacks {', '.join(sorted(missing))}: write it with gabf.write_network.")
    try:
        return Network(**arrays, kernel=kernel)
    except PlannerError as error:
        raise type(error)(f"network {path}: {error}.") from None


def _write_member(archive: zipfile.ZipFile, file: IO[bytes], name: str, array: np.ndarray) -> None:
    """A member whose data, behind headers, begin at a multiple of ``_ALIGNED``; NumPy pads its own header to that."""
    info = zipfile.ZipInfo(name)
    begin = file.tell() + _LOCAL_HEADER + len(name) + _ZIP64_EXTRA + 4
    padding = -begin % _ALIGNED
    info.extra = np.array([_PADDING, padding], dtype="<u2").tobytes() + bytes(padding)
    with archive.open(info, "w", force_zip64=True) as member:
        np.lib.format.write_array(member, array, allow_pickle=False)


def _read_member(archive: zipfile.ZipFile, file: IO[bytes], info: zipfile.ZipInfo) -> Any:
    if info.compress_type != zipfile.ZIP_STORED or info.file_size < _MAP_FROM:
        with archive.open(info) as member:
            return np.lib.format.read_array(member, allow_pickle=False)
    file.seek(info.header_offset)
    header = file.read(_LOCAL_HEADER)
    name, extra = np.frombuffer(header[26:30], dtype="<u2")
    file.seek(int(name) + int(extra), os.SEEK_CUR)
    shape, fortran, dtype = array_header(file)
    if fortran or dtype.hasobject:
        raise ValueError(f"'{info.filename}' holds no plain array")
    return np.memmap(file, dtype, "r", file.tell(), shape)
