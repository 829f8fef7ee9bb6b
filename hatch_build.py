"""Compiles the planner's inner loops (planner/native/source) when the package is built or installed.

With the C++ compiler of the machine (``$CXX``, c++, g++ or clang++), or where there is none with the one that the
package ziglang brings. ``python hatch_build.py`` compiles into the source tree.
"""

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # as a script, without hatchling
    BuildHookInterface = object

SOURCE = Path("planner/native/source")
LIBRARY = Path("planner/native/libplanner.so")
# nothing is fused and no sum reordered: the same bits from every compiler; errno and floating-point traps, which nobody
# reads, would keep loops from being worked on several numbers at a time
ARITHMETIC = ["-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
FLAGS = ["-std=c++17", "-O3", *ARITHMETIC, "-fPIC", "-shared", "-pthread", "-Wall", "-Wextra"]


def own_compiler():
    """The machine's compiler as a command, or None."""
    named = shlex.split(os.environ.get("CXX", ""))
    found = next((path for name in ("c++", "g++", "clang++") if (path := shutil.which(name))), None)
    return named or ([found] if found else None)


def compiler():
    """The command that compiles."""
    command = own_compiler()
    if command is None and importlib.util.find_spec("ziglang"):
        command = [sys.executable, "-m", "ziglang", "c++"]
    if command is None:
        sys.exit("no C++ compiler was found: install one, or the Python package ziglang, which is one ('make' does).")
    return command


def compile_library(root, library=LIBRARY, more=()):
    """Compile, unless the library is newer than all that it is made of; ``more`` flags, which overrule the others."""
    library, parts = root / library, [*(root / SOURCE).rglob("*"), Path(__file__)]
    if library.exists() and library.stat().st_mtime > max(part.stat().st_mtime for part in parts):
        return
    library.parent.mkdir(parents=True, exist_ok=True)
    fresh = library.with_suffix(".new")
    subprocess.run([*compiler(), *FLAGS, *more, str(root / SOURCE / "library.cpp"), "-o", str(fresh)], check=True)
    fresh.replace(library)


class NativeBuildHook(BuildHookInterface):
    PLUGIN_NAME = "custom"

    def dependencies(self):
        return [] if own_compiler() else ["ziglang>=0.13"]

    def initialize(self, version, build_data):
        if self.target_name != "wheel":
            return
        compile_library(Path(self.root))
        build_data["artifacts"].append(str(LIBRARY))
        build_data["pure_python"] = False
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"py3-none-{platform}"  # one library serves every Python


if __name__ == "__main__":
    compile_library(Path(__file__).parent)
