"""The generalized adaptive Bellman-Ford dynamics (GABF): every law, kernel and bound of the paper.

>>> net = gabf.Network([0, 0, 1, 3], [0, 0, 1], [1.0, 5.0, 1.0], sources=[0], node_cost=[0.2, 0.4, 0.9])
>>> result = gabf.solve(net, law=gabf.SingularityFree(T=4.0))
>>> gabf.extract_path(net, result, start=2)
array([2, 1, 0])

This package needs NumPy and the compiled library, and no robots.
"""

from planner.base.errors import ArrayError, AssumptionError, OptionError, PlannerError, StateError
from planner.gabf import learning
from planner.gabf.certificates import Assumption, Certificate, T_star, certify
from planner.gabf.healing import Healing, heal, raise_start
from planner.gabf.kernels import (
    Additive,
    EdgeIntegral,
    Kernel,
    Multiplicative,
    NodeDependent,
    TradeOff,
    UserKernel,
)
from planner.gabf.laws import (
    FixedTime,
    Law,
    Nominal,
    PrescribedClock,
    PrescribedTime,
    SingularityFree,
    UniformClock,
    UserLaw,
    control_input,
    law_from_name,
)
from planner.gabf.network import Network
from planner.gabf.oracle import (
    Structure,
    bellman_operator,
    max_error,
    oracle,
    structure,
    true_parents,
    value_iteration,
)
from planner.gabf.path import cheapest_path, extract_path
from planner.gabf.problem import Premises, overestimate
from planner.gabf.solve import CostToGo, Ending, FieldHistory, solve
from planner.gabf.splitting import Splitting

__all__ = [
    "Additive",
    "ArrayError",
    "Assumption",
    "AssumptionError",
    "Certificate",
    "CostToGo",
    "EdgeIntegral",
    "Ending",
    "FieldHistory",
    "FixedTime",
    "Healing",
    "Kernel",
    "Law",
    "Multiplicative",
    "Network",
    "NodeDependent",
    "Nominal",
    "OptionError",
    "PlannerError",
    "Premises",
    "PrescribedClock",
    "PrescribedTime",
    "SingularityFree",
    "Splitting",
    "StateError",
    "Structure",
    "T_star",
    "TradeOff",
    "UniformClock",
    "UserKernel",
    "UserLaw",
    "bellman_operator",
    "certify",
    "cheapest_path",
    "control_input",
    "extract_path",
    "heal",
    "law_from_name",
    "learning",
    "max_error",
    "oracle",
    "overestimate",
    "raise_start",
    "solve",
    "structure",
    "true_parents",
    "value_iteration",
]
