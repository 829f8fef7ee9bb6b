"""The tests of the compiled library under the address and undefined-behaviour sanitizers: ``make sanitize``.

    python -m tests.native.sanitized                    # what follows goes to pytest
    python -m tests.native.sanitized thread             # data races instead

The library is compiled a second time, into ``build``, and takes the place of the installed one before a test is
imported. A sanitizer has to be in a process before Python is, so the tests run in another one.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
HERE = "tests.native.sanitized"
LIBRARY = "SANITIZED_LIBRARY"  # the variable that says to the other process which one
RUNTIME = {"address": "libasan.so", "thread": "libtsan.so"}
CHECKS = {"address": "address,undefined", "thread": "thread"}
OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=0",  # Python keeps what it has to its end
    "UBSAN_OPTIONS": "print_stacktrace=1",
    "TSAN_OPTIONS": "ignore_noninstrumented_modules=1",  # locks that are not compiled with it are unknown to it
}
# calls past the door that read behind an array, or write into one at once: who would not see these looked at nothing
CHAIN = f"""
import threading
import numpy as np
import {HERE}
from planner.native.library import NativeChain, _at, _library
turns = np.zeros((1, 3, 3, 3))
chain = NativeChain(np.zeros(1), np.zeros(1), turns, *np.zeros((3, 1, 3)))
q, point, found = np.zeros(1000), np.zeros(3), np.zeros((1001, 3))
"""
SEEN = {
    "address": (
        "heap-buffer-overflow",
        CHAIN + "_library.chain_points(chain.handle, 1001, _at(q), 1, _at(point), _at(found))",
    ),
    "thread": (
        "data race",
        CHAIN
        + """
ask = lambda: [_library.chain_points(chain.handle, 1000, _at(q), 1, _at(point), _at(found)) for _ in range(100)]
both = [threading.Thread(target=ask) for _ in range(2)]
any(thread.start() for thread in both), any(thread.join() for thread in both)
""",
    ),
}


def main(arguments: list[str]) -> int:
    """Compile, see that the sanitizer sees, and run the tests; what pytest returns."""
    kind = arguments.pop(0) if arguments[:1] == ["thread"] else "address"
    # the C++ runtime as well: the sanitizer looks for what throws before the library brings it
    preloaded = " ".join(map(runtime, (RUNTIME[kind], "libstdc++.so.6")))
    whole = os.environ | OPTIONS | {"LD_PRELOAD": preloaded, LIBRARY: str(compiled(kind)), "PYTHONPATH": str(ROOT)}
    words, calls = SEEN[kind]
    seen = subprocess.run([sys.executable, "-c", calls], env=whole, capture_output=True, text=True, check=False)
    if words not in seen.stderr:
        sys.exit(f"the sanitizer did not see a {words}: {seen.stderr[-2000:]}")
    tests = arguments or [str(ROOT / "tests/native")]
    command = [sys.executable, "-m", "pytest", "-q", "-p", HERE, "-p", "no:cacheprovider", "-s", *tests]
    return subprocess.run(command, env=whole, cwd=ROOT, check=False).returncode


def runtime(name: str) -> str:
    """Where the compiler has a library of its own."""
    found = subprocess.run(
        ["gcc", f"-print-file-name={name}"], check=True, capture_output=True, text=True
    ).stdout.strip()
    if not Path(found).is_absolute():
        sys.exit(f"{name} was not found: install GCC with its sanitizers.")
    return found


def compiled(kind: str) -> Path:
    """The library with the checks of one ``kind`` in it."""
    sys.path.insert(0, str(ROOT))
    from hatch_build import compile_library

    os.environ["CXX"] = "g++"  # whose sanitizers are preloaded
    path = Path("build") / kind / "libplanner.so"
    checks = [f"-fsanitize={CHECKS[kind]}", "-fno-sanitize-recover=undefined", "-O1", "-g", "-fno-omit-frame-pointer"]
    compile_library(ROOT, path, checks)
    return ROOT / path


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
elif LIBRARY in os.environ:  # as a plugin of pytest, which loads it before anything that asks the library
    from planner.native import loading

    loading.library = loading.load(Path(os.environ[LIBRARY]))
