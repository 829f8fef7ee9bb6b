"""The compiled inner loops: kinematics, distances, proofs of motions, detours, flows. C++ in ``source``.

``planner.native.compiled`` holds functions and classes over NumPy's arrays: float64 and int64, angles rad, lengths m,
times s unless ns. nanobind refuses arrays of another type or shape (TypeError); numbers that nothing can be computed
from are an :class:`ArrayError`. Every call leaves other Python threads running, and hears Ctrl-C while it lasts. What
is made here may be asked by several threads at once, but for a ``Look``. Sums are added in one order and nothing is
fused, so that every compiler and processor gives the same bits, on one thread or many.
"""

from planner.base.errors import InstallationError

try:
    import planner.native.compiled  # noqa: F401
except ImportError as error:
    raise InstallationError(
        f"the compiled part of the planner cannot be loaded ({error}): install the package again ('make' or "
        "'pip install .'), which compiles it."
    ) from None
