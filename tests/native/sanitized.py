"""The tests of the compiled code under the address and undefined-behaviour sanitizers: ``make sanitize``.

    python -m tests.native.sanitized                    # what follows goes to pytest
    python -m tests.native.sanitized thread             # data races instead

The module is compiled a second time, into ``build``, and takes the place of the installed one before a test is
imported. A sanitizer has to be in a process before Python is, so the tests run in another one.
"""

import os
import shutil
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

ROOT = Path(__file__).parents[2]
HERE = "tests.native.sanitized"
MODULE = "SANITIZED_MODULE"  # the variable that says to the other process which one
RUNTIME = {"address": "libasan.so", "thread": "libtsan.so"}
CHECKS = {"address": "address,undefined", "thread": "thread"}
OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=0",  # Python keeps what it has to its end
    "UBSAN_OPTIONS": "print_stacktrace=1",
    "TSAN_OPTIONS": "ignore_noninstrumented_modules=1",  # locks that are not compiled with it are unknown to it
}
# an array that is shorter than it says, and one that two threads write into: who would not see these looked at nothing
FLOW = f"""
import threading
import numpy as np
import {HERE}
from planner.native.compiled import NativeFlow
flow, y = NativeFlow(1.0, 1.0, 0.0, 0.0), np.ones(5000)
"""
SEEN = {
    "address": (
        "heap-buffer-overflow",
        FLOW + "flow.moved(0, np.lib.stride_tricks.as_strided(y, (5001,), (8,)), 0.1)",
    ),
    "thread": (
        "data race",
        FLOW
        + """
ask = lambda: [flow.sketch(None, y, y, 0.1, y) for _ in range(100)]
both = [threading.Thread(target=ask) for _ in range(2)]
any(thread.start() for thread in both), any(thread.join() for thread in both)
""",
    ),
}


def main(arguments: list[str]) -> int:
    """Compile, try the sanitizer on a known error, and run the tests; the exit code of pytest."""
    kind = arguments.pop(0) if arguments[:1] == ["thread"] else "address"
    # the C++ runtime as well: the sanitizer looks for what throws before the module brings it
    preloaded = " ".join(map(runtime, (RUNTIME[kind], "libstdc++.so.6")))
    whole = os.environ | OPTIONS | {"LD_PRELOAD": preloaded, MODULE: str(compiled(kind)), "PYTHONPATH": str(ROOT)}
    words, calls = SEEN[kind]
    seen = subprocess.run([sys.executable, "-c", calls], env=whole, capture_output=True, text=True, check=False)
    if words not in seen.stderr:
        sys.exit(f"the sanitizer did not see a {words}: {seen.stderr[-2000:]}")
    tests = arguments or [str(ROOT / "tests/native")]
    command = [sys.executable, "-m", "pytest", "-q", "-p", HERE, "-p", "no:cacheprovider", "-s", *tests]
    return subprocess.run(command, env=whole, cwd=ROOT, check=False).returncode


def runtime(name: str) -> str:
    """The path of a library of the compiler."""
    found = subprocess.run(
        ["gcc", f"-print-file-name={name}"], check=True, capture_output=True, text=True
    ).stdout.strip()
    if not Path(found).is_absolute():
        sys.exit(f"{name} was not found: install GCC with its sanitizers.")
    return found


def compiled(kind: str) -> Path:
    """The module with the checks of one ``kind`` in it, by GCC, whose sanitizers are preloaded."""
    here = str(Path(sys.executable).parent)
    cmake, ninja = (shutil.which(name, path=here) or name for name in ("cmake", "ninja"))
    folder, given = ROOT / "build" / kind, [f"-DSANITIZER={CHECKS[kind]}", f"-DPython_EXECUTABLE={sys.executable}"]
    given += ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_COMPILER=g++", f"-DCMAKE_MAKE_PROGRAM={ninja}"]
    subprocess.run([cmake, "-G", "Ninja", "-S", ROOT, "-B", folder, *given], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([cmake, "--build", folder, "--target", "compiled"], check=True)
    return next(folder.glob("compiled.*.so"))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
elif MODULE in os.environ:  # as a plugin of pytest, which loads it before anything that asks the module
    spec = spec_from_file_location("planner.native.compiled", os.environ[MODULE])
    assert spec is not None
    assert spec.loader is not None
    sys.modules[spec.name] = module_from_spec(spec)
    spec.loader.exec_module(sys.modules[spec.name])
