"""The built-in robots and scenes, and the versions of the software behind a result."""

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
    """Return the folder of built-in "robots" or "scenes", in the wheel or next to it in a clone."""
    packaged = _PACKAGE / "_data" / kind
    return packaged if packaged.is_dir() else _PACKAGE.parent / kind


def robots_folder() -> Path:
    return data_folder("robots")


def scenes_folder() -> Path:
    return data_folder("scenes")


def robot_names() -> list[str]:
    """Return the names of the built-in robots, sorted."""
    return sorted(path.parent.name for path in robots_folder().glob("*/robot.yaml"))


def scene_names() -> list[str]:
    """Return the names of the built-in scenes with states for every built-in robot, sorted."""
    return sorted(path.stem for path in scenes_folder().glob("*.yaml"))


def list_published_scenes() -> list[str]:
    """Return the names of the built-in scenes of published problems, sorted; each is for some robots."""
    return sorted(path.stem for path in (scenes_folder() / "published").glob("*.yaml"))


def scene_file(name: str) -> Path | None:
    """Return the file of a built-in scene; None for another name."""
    if name in scene_names():
        return scenes_folder() / f"{name}.yaml"
    return scenes_folder() / "published" / f"{name}.yaml" if name in list_published_scenes() else None


def versions(packages: tuple[str, ...] = DECISIVE) -> dict[str, str]:
    """Return the installed versions of ``packages``, and of "python", "libc" and "machine"."""
    own = {
        "python": platform.python_version(),
        "libc": " ".join(platform.libc_ver()),
        "machine": platform.machine(),
    }
    return {name: own[name] if name in own else importlib.metadata.version(name) for name in packages}


@cache
def software(*folders: Path) -> str:
    """Return the versions, and a hash of the sources of this package and of more ``folders``."""
    digest = hashlib.sha256()
    for folder in (_PACKAGE, *folders):
        for path in sorted([*folder.rglob("*.py"), *folder.rglob("*.[ch]pp")]):
            digest.update(f"{path.relative_to(folder)}\0".encode() + path.read_bytes() + b"\0")
    return ", ".join([*(" ".join(item) for item in versions().items()), f"source {digest.hexdigest()[:8]}"])
