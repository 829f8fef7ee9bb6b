"""An example of each public class of ``planner.gabf``; the pages of the reference show them, and a test runs them."""

# --- Additive ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3, kernel=gabf.Additive())
gabf.solve(network).x  # [3. 2. 0.]
# --- ArrayError ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
try:
    gabf.cheapest_path(gabf.solve(network), starts=[])
except gabf.ArrayError as error:
    print(error)
# --- Assumption ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
law = gabf.SingularityFree(T=4.0)
for certificate in gabf.certify(network, law, gabf.solve(network, law)):
    print(certificate.name, [(each.name, each.holds, each.value) for each in certificate.assumptions])
# --- AssumptionError ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
try:
    gabf.solve(network, law="nominal", x0=[0.0, 0.0, 0.0])  # the nominal law needs an overestimate
except gabf.AssumptionError as error:
    print(error)
# --- Certificate ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
law = gabf.SingularityFree(T=4.0)
for certificate in gabf.certify(network, law, gabf.solve(network, law)):
    print(certificate.equation, certificate.bound, certificate.measured, certificate.holds)
# --- CostToGo ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
field = gabf.solve(network, law=gabf.SingularityFree(T=4.0))
field.x, field.settling_time, field.outcome  # [3. 2. 0.], s, Ending.SETTLED
# --- EdgeIntegral ---
from planner import gabf

kernel = gabf.EdgeIntegral(beta=0.5)
network = gabf.Network([0, 0, 1], [0], [1.0], sources=[0], arc_cost=[0.4], kernel=kernel)
gabf.solve(network).x  # [0. 0.7]
# --- Ending ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
gabf.solve(network).outcome is gabf.Ending.SETTLED  # True
# --- FieldHistory ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
history = gabf.solve(network, save_every=1).history
history.tau, history.x, history.u  # (k,), (k, 3), (k, 3)
# --- FixedTime ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
gabf.solve(network, law=gabf.FixedTime(eta=15.0)).settling_time
# --- Healing ---
from planner import gabf

before = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
after = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 5.0], sources=[2], n_nodes=3)
healing = gabf.heal(after, gabf.solve(before).x)
healing.cost_to_go.x, healing.raised  # [6. 5. 0.], nodes that were raised first
# --- Kernel ---
from planner import gabf

isinstance(gabf.TradeOff(beta=0.5), gabf.Kernel)  # True: Additive, TradeOff, EdgeIntegral, Multiplicative, UserKernel
# --- Law ---
from planner import gabf

law = gabf.law_from_name("singularity-free", 4.0)
law.prescribed_time  # 4.0
# --- Multiplicative ---
from planner import gabf

kernel = gabf.Multiplicative()
network = gabf.Network.from_arcs([0, 1], [1, 2], [0.9, 0.8], sources=[2], n_nodes=3, kernel=kernel)
gabf.solve(network).x  # 1 - the product of the weights along the path
# --- Network ---
import scipy.sparse

from planner import gabf

graph = scipy.sparse.csr_array([[0, 0, 0], [1.0, 0, 0], [5.0, 1.0, 0]])  # entry (i, j): node i reads node j
network = gabf.Network.from_scipy(graph, sources=[0])
gabf.solve(network).x  # [0. 1. 2.]
# --- NodeDependent ---
from planner import gabf

kernel = gabf.NodeDependent()
network = gabf.Network.from_arcs([1], [0], [1.0], sources=[0], source_values=[1.0], n_nodes=2, kernel=kernel)
gabf.solve(network).x
# --- Nominal ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
gabf.solve(network, law=gabf.Nominal(eta=1.0)).x
# --- OptionError ---
from planner import gabf

try:
    gabf.SingularityFree(T=-1.0)
except gabf.OptionError as error:
    print(error)
# --- PlannerError ---
from planner import gabf

try:
    gabf.solve(None)
except (gabf.PlannerError, TypeError, AttributeError) as error:
    print(error)
# --- Premises ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
premises = gabf.solve(network).premises
premises.zeta, premises.L  # constants of eq. (progressive) and eq. (Lipschitz)
# --- PrescribedClock ---
from planner import gabf

clock = gabf.PrescribedClock(T=4.0)
clock.tau(2.0), clock.time(1.0)
# --- PrescribedTime ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
gabf.solve(network, law=gabf.PrescribedTime(T=4.0)).x
# --- SingularityFree ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
gabf.solve(network, law=gabf.SingularityFree(T=4.0)).settling_time  # below 4
# --- Splitting ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
gabf.solve(network, solver=gabf.Splitting(tolerance=0.005)).settling_time  # closer, by more steps
# --- StateError ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
try:
    gabf.extract_path(network, gabf.solve(network), start=7)
except gabf.PlannerError as error:
    print(error)
# --- Structure ---
from planner import gabf

network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
gabf.structure(network).x_star  # [3. 2. 0.]
# --- TradeOff ---
from planner import gabf

kernel = gabf.TradeOff(beta=0.5)
network = gabf.Network([0, 0, 1], [0], [1.0], sources=[0], node_cost=[0.2, 0.4], kernel=kernel)
gabf.solve(network).x  # [0. 0.6]
# --- UniformClock ---
from planner import gabf

gabf.UniformClock(eta=2.0).tau(1.0)  # 2.0
# --- UserKernel ---
import numpy as np

from planner import gabf

kernel = gabf.UserKernel(lambda i, a, b: np.hypot(a, b) + b)
network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3, kernel=kernel)
gabf.solve(network).x
# --- UserLaw ---
from planner import gabf

law = gabf.UserLaw(np.tanh, gabf.PrescribedClock(T=4.0))
network = gabf.Network.from_arcs([0, 1], [1, 2], [1.0, 2.0], sources=[2], n_nodes=3)
gabf.solve(network, law=law).x  # [3. 2. 0.]
# ---
