"""Singularity-averse path planning for robot arms.

    import planner
    found = planner.plan("panda", "shelf", beta=0.2)
    found.path                       # (k, dof) rad
    found.trajectory                 # the motion in time

Start reading at :mod:`planner.planning.plan`. The names below are loaded on first use (they stand in ``__init__.pyi``),
so that importing the package, or only :mod:`planner.gabf`, loads no robot library.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
