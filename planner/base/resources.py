"""The robots and scenes that travel with the package, and the versions of the software that results come from."""

import hashlib
import importlib.metadata
import platform
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]
__version__ = importlib.metadata.version("gabf-planner")
# a plan's numbers depend on these; the C library gives the last bits of a sine
DECISIVE = ("gabf-planner", "ompl", "pin", "python-fcl", "coal", "numpy", "python", "libc", "machine")


def data_folder(kind: str) -> Path:
    """The folder of built-in files of one ``kind``, "robots" or "scenes": in the wheel, or beside it in a checkout."""
    packaged = _PACKAGE / "_data" / kind
    return packaged if packaged.is_dir() else _PACKAGE.parent / kind


def robots_folder() -> Path:
    return data_folder("robots")


def scenes_folder() -> Path:
    return data_folder("scenes")


def robot_names() -> list[str]:
    """Names of the built-in robots, sorted."""
    return sorted(path.parent.name for path in robots_folder().glob("*/robot.yaml"))


def scene_names() -> list[str]:
    """Names of the built-in scenes that every built-in robot has states in, sorted."""
    return sorted(path.stem for path in scenes_folder().glob("*.yaml"))


def list_published_scenes() -> list[str]:
    """Names of the built-in scenes of published problems, each for the robots that it names, sorted."""
    return sorted(path.stem for path in (scenes_folder() / "published").glob("*.yaml"))


def scene_file(name: str) -> Path | None:
    """The file of a built-in scene; None where there is none of that name."""
    if name in scene_names():
        return scenes_folder() / f"{name}.yaml"
    return scenes_folder() / "published" / f"{name}.yaml" if name in list_published_scenes() else None


def versions(packages: tuple[str, ...] = DECISIVE) -> dict[str, str]:
    """Installed versions of ``packages``; "python", "libc" and "machine" are the interpreter's and below it."""
    own = {
        "python": platform.python_version(),
        "libc": " ".join(platform.libc_ver()),
        "machine": platform.machine(),
    }
    return {name: own[name] if name in own else importlib.metadata.version(name) for name in packages}


@cache
def software(*folders: Path) -> str:
    """Versions, and a hash of the sources of this package and of more ``folders``: rows of other software are stale."""
    digest = hashlib.sha256()
    for folder in (_PACKAGE, *folders):
        for path in sorted([*folder.rglob("*.py"), *folder.rglob("*.[ch]pp")]):
            digest.update(f"{path.relative_to(folder)}\0".encode() + path.read_bytes() + b"\0")
    return ", ".join([*(" ".join(item) for item in versions().items()), f"source {digest.hexdigest()[:8]}"])
