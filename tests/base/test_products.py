"""The same command and seed on processors for which NumPy, its BLAS and LAPACK choose other code."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.base.products import dot, length, product

_FLAGS = Path("/proc/cpuinfo")
_NEEDS = {"Prescott": "sse2", "Haswell": "avx2", "SkylakeX": "avx512vl"}  # OpenBLAS' code, and what it takes

_OTHERWISE = """
import numpy as np
rng = np.random.default_rng(0)
parts = np.linalg.qr(rng.normal(size=(7, 6)), mode="r"), rng.normal(size=7) @ rng.normal(size=(7, 50))
print(*(part.tobytes().hex() for part in parts))
"""

_PLANS = {
    "default": (),
    "floor": ("--min-manipulability", "0.03", "--charge", "edges", "--manipulability-cost", "log"),
    "panda": ("--robot", "panda", "--scene", "shelf", "--collision", "coal"),
}


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


def _planned(options: tuple[str, ...], out: Path, **environment: str) -> tuple[str, list[list[float]]]:
    """The hash of the roadmap and the path."""
    arguments = ("-m", "planner", "plan", "--nodes", "60", *options, "--out", str(out), "--json")
    record = json.loads(_printed(*arguments, **environment))
    return record["roadmap"]["sha256"], record["path"]


@pytest.mark.skipif(len(_runnable()) < 2, reason="needs an x86-64 processor with AVX2, on Linux")
@pytest.mark.parametrize("options", _PLANS.values(), ids=_PLANS)
def test_the_same_bits_whatever_blas_is_made_for(options: tuple[str, ...], tmp_path: Path) -> None:
    """Before, 100 nodes of the default had paths that cost 1.07 or 1.29, by the processor that BLAS was told."""
    first, *others = (_planned(options, tmp_path, OPENBLAS_CORETYPE=core) for core in _runnable())
    assert all(other == first for other in others)


@pytest.mark.skipif(len(_runnable()) < 2, reason="needs an x86-64 processor with AVX2, on Linux")
def test_blas_is_told_another_processor() -> None:
    """That its code differs, or the test above would hold for nothing."""
    printed = [_printed("-c", _OTHERWISE, OPENBLAS_CORETYPE=core) for core in _runnable()]
    assert len(set(printed)) > 1


@pytest.mark.skipif("SkylakeX" not in _runnable(), reason="needs a processor with AVX-512, on Linux")
def test_the_same_bits_without_numpys_own_wide_code(tmp_path: Path) -> None:
    wide, narrow = (
        _planned(_PLANS["floor"], tmp_path, NPY_DISABLE_CPU_FEATURES=features) for features in ("", "X86_V4 AVX512_ICL")
    )
    assert wide == narrow


@pytest.mark.parametrize("k", [1, 2, 3, 7, 12])
def test_products_are_those_of_numpy(k: int) -> None:
    rng = np.random.default_rng(k)
    a, b, c = rng.normal(size=(5, k)), rng.normal(size=(k, 4)), rng.normal(size=k)
    close: dict[str, Any] = {"rtol": 1e-13, "atol": 1e-14}
    np.testing.assert_allclose(product(a, b), a @ b, **close)
    np.testing.assert_allclose(product(c, b), c @ b, **close)
    np.testing.assert_allclose(product(a, c), a @ c, **close)
    np.testing.assert_allclose(product(a[:, None], c), (a @ c)[:, None], **close)
    assert product(a[:0], b).shape == (0, 4)
    np.testing.assert_allclose(dot(a[0], c), a[0] @ c, **close)
    np.testing.assert_allclose(length(c), np.linalg.norm(c), **close)
    assert length(np.full(k, 1e300)) == np.inf
    assert np.isnan(length(np.full(k, np.nan)))
