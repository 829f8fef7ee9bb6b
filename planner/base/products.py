"""Products of small arrays with the same last bits on every processor that a plan promises them for.

NumPy leaves ``@`` and ``np.linalg`` to BLAS and LAPACK, which choose their code by the processor: of twenty kinds of
products and factors that planning asks for, eleven came out otherwise with OpenBLAS' code for AVX-512 than with that
for AVX2, and a difference in the last bit can change the roadmap. Left to ``@`` are products of matrices, or of stacks
of them, that sum over three terms: all code for processors with fused multiply-add (FMA) adds these up alike, and they
are most work.
"""

from __future__ import annotations

import math

import numpy as np

from planner.base.arrays import Floats


def product(a: Floats, b: Floats) -> Floats:
    """``a @ b``, for b (k, n) or (k,) and a (..., k); several times slower where both are large."""
    return np.einsum("...k,kn->...n", a, b) if b.ndim == 2 else np.einsum("...k,k->...", a, b)


def dot(a: Floats, b: Floats) -> float:
    """The inner product of two short vectors (k,), in Python's numbers: for k = 3 in half the time that ``@`` takes."""
    total = 0.0
    for x, y in zip(a.tolist(), b.tolist(), strict=True):
        total += x * y
    return total


def length(vector: Floats) -> float:
    """The Euclidean norm of a short vector (k,)."""
    return math.sqrt(dot(vector, vector))
