"""Compiled inner loops: kinematics, distances, proofs of motions, detours, flows; C++ in ``source``.

``planner.native.compiled`` has functions and classes on NumPy arrays: float64 and int64; rad, m, s unless ns. nanobind
refuses other types and shapes (TypeError); invalid numbers raise :class:`ArrayError`. Calls release the GIL and respond
to Ctrl-C. Objects may be used by several threads, except a ``Look``. Sums have a fixed order and no fused operations,
so every compiler and processor gives the same bits, on any number of threads.
"""

from planner.base.errors import InstallationError

try:
    import planner.native.compiled  # noqa: F401
except ImportError as error:
    raise InstallationError(
        f"the compiled part of the planner cannot be loaded ({error}): install the package again ('make' or "
        "'pip install .'), which compiles it."
    ) from None
