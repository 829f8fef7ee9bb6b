"""The same command and seed on processors for which NumPy, its BLAS and LAPACK choose other code."""

import json
import os
import platform
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import pytest

_FLAGS = Path("/proc/cpuinfo")
_NEEDS = {"Prescott": "sse2", "Haswell": "avx2", "SkylakeX": "avx512vl"}  # OpenBLAS' code, and what it takes

_OTHERWISE = """
import numpy as np
rng = np.random.default_rng(0)
parts = np.linalg.qr(rng.normal(size=(7, 6)), mode="r"), rng.normal(size=7) @ rng.normal(size=(7, 50))
print(*(part.tobytes().hex() for part in parts))
"""

_PLANS = (("--min-manipulability", "0.03", "--manipulability-cost", "log", "--collision", "coal", "--no-page"),)

# every plan in one process; for each the hash of the roadmap, and the path
_PLANNED = """
import contextlib, io, json, sys
from planner import cli
plans, folder = json.loads(sys.argv[1]), sys.argv[2]
for options in plans:
    sys.argv, record = ["planner", "plan", "--nodes", "20", "--out", folder, "--json", *options], io.StringIO()
    with contextlib.suppress(SystemExit), contextlib.redirect_stdout(record):
        cli.main()
    print(json.loads(record.getvalue())["roadmap"]["sha256"], json.loads(record.getvalue())["path"])
"""


def _runnable() -> list[str]:
    if platform.machine() not in ("x86_64", "AMD64") or not _FLAGS.exists():
        return []
    flags = set(_FLAGS.read_text().split())
    return [core for core, flag in _NEEDS.items() if flag in flags]


def _printed(*arguments: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, **environment},
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


@cache
def _planned(core: str, without: str = "") -> str:
    """Plans by BLAS for the processor ``core``, and by NumPy ``without`` these features."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {"OPENBLAS_CORETYPE": core, "NPY_DISABLE_CPU_FEATURES": without}
        return _printed("-c", _PLANNED, json.dumps(_PLANS), folder, **environment)


@pytest.mark.skipif(len(_runnable()) < 2, reason="needs an x86-64 processor with AVX2, on Linux")
def test_the_same_bits_whatever_blas_is_made_for() -> None:
    """Before, 100 nodes of the default had paths that cost 1.07 or 1.29, by the processor of BLAS."""
    oldest, *_, newest = _runnable()
    assert _planned(oldest) == _planned(newest)


@pytest.mark.skipif(len(_runnable()) < 2, reason="needs an x86-64 processor with AVX2, on Linux")
def test_blas_runs_as_on_another_processor() -> None:
    """That its code differs, or the test above would hold for nothing."""
    printed = [_printed("-c", _OTHERWISE, OPENBLAS_CORETYPE=core) for core in _runnable()]
    assert len(set(printed)) > 1


@pytest.mark.skipif("SkylakeX" not in _runnable(), reason="needs a processor with AVX-512, on Linux")
def test_the_same_bits_without_numpys_own_wide_code() -> None:
    assert _planned("SkylakeX", without="X86_V4 AVX512_ICL") == _planned("SkylakeX")
