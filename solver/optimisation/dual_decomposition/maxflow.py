"""Maxflow subproblem: candidates with their pairwise costs, without constraints.

Minimising a quadratic function of binary variables is hard in general; its roof dual, the optimum
of the linear relaxation, is a minimum cut in a graph with two nodes for each variable, one for it
and one for its complement (Boros and Hammer, "Pseudo-Boolean optimization", 2002). The relaxed
variables are 0, 1/2 or 1.
"""

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import maximum_flow

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.kernel import kernel
from solver.optimisation.dual_decomposition.exchange import Used

_UNITS = 2**30
"""Integer units that bound a flow: SciPy's are 32 bits wide, a residual capacity is twice that."""
_MOST_ROUNDS, _NEGLIGIBLE = 3, 1e-12
"""Rounds of integer flow, and the share of the first one's capacity below which no more is sent."""


class MaxflowSubproblem:
    """Roof duality for minimising Σ u_a x_a + Σ p_ab x_a x_b over binary x.

    Parameters
    ----------
    first, second
        (E,) candidates of the pairwise costs.
    unary
        (V,) unary costs u; kept, not copied.
    pairwise
        (E,) pairwise costs p; kept, not copied.

    Attributes
    ----------
    labels
        (V,) the minimiser: 0, 1/2 or 1 for each candidate.
    products
        (E,) value of x_a x_b in the minimiser: 0, 1/2 or 1.
    """

    def __init__(
        self, first: IntArray, second: IntArray, unary: FloatArray, pairwise: FloatArray
    ) -> None:
        self.unary, self.pairwise = unary, pairwise
        self._first, self._second = first, second
        self.labels: FloatArray = np.zeros(len(unary))
        self.products: FloatArray = np.zeros(len(first))

    def minimise(self) -> float:
        """Solve the relaxation.

        Returns
        -------
        A lower bound of the minimum over binary variables; with non-positive pairwise costs the
        minimum itself. It is the value of a flow, so it is valid even where that is not maximal.
        """
        count = len(self.unary)
        negative = self.pairwise < 0.0
        linear = 0.5 * self.unary
        np.add.at(linear, self._first[negative], 0.5 * self.pairwise[negative])
        flow, side = minimum_cut(*self._arcs(linear, negative), 2 * count, 2 * count + 1)
        self._label(side[:count], ~side[count : 2 * count], negative)
        return 2.0 * float(np.minimum(linear, 0.0).sum()) + flow

    def _arcs(
        self, linear: FloatArray, negative: BoolArray
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Arcs of the doubled graph: node a is x_a, node V + a is y_a, in place of 1 − x_a.

        A node is on the source's side when x_a = 1, or when y_a = 0 as a complement.
        """
        count = len(self.unary)
        source, sink = 2 * count, 2 * count + 1
        nodes = np.arange(count)
        positive = linear >= 0.0
        costs, gains = nodes[positive], nodes[~positive]
        a, b = self._first[negative], self._second[negative]
        c, d = self._first[~negative], self._second[~negative]
        strength = 0.5 * np.abs(self.pairwise)
        pieces = [
            (costs, np.full(len(costs), sink), linear[positive]),
            (np.full(len(costs), source), count + costs, linear[positive]),
            (np.full(len(gains), source), gains, -linear[~positive]),
            (count + gains, np.full(len(gains), sink), -linear[~positive]),
            (a, b, strength[negative]),
            (count + b, count + a, strength[negative]),
            (c, count + d, strength[~negative]),
            (d, count + c, strength[~negative]),
        ]
        tails, heads, capacities = (np.concatenate(column) for column in zip(*pieces, strict=True))
        return tails, heads, capacities

    def _label(self, taken: BoolArray, complement: BoolArray, negative: BoolArray) -> None:
        x, z = taken.astype(np.float64), complement.astype(np.float64)
        a, b = self._first, self._second
        self.labels = 0.5 * (x + z)
        together = 0.5 * (x[a] * x[b] + z[a] * z[b])
        crossed = 0.5 * (x[a] * z[b] + z[a] * x[b])
        self.products = np.where(negative, together, crossed)

    @property
    def used_unary(self) -> Used:
        """Unary costs that the minimiser uses."""
        chosen = np.flatnonzero(self.labels)
        return Used(chosen, self.labels[chosen])

    @property
    def used_pairwise(self) -> Used:
        """Pairwise costs that the minimiser uses."""
        chosen = np.flatnonzero(self.products)
        return Used(chosen, self.products[chosen])


def minimum_cut(
    tails: IntArray, heads: IntArray, capacities: FloatArray, source: int, sink: int
) -> tuple[float, BoolArray]:
    """Maximum flow and minimum cut of a graph with real capacities.

    SciPy's flows are 32-bit integers. Capacities are therefore rounded down to integer units; what
    rounding leaves is sent in further rounds, each time in units that are smaller by the factor
    |E| / 2³⁰. Every round sends a flow within the residual capacities, so that the value never
    exceeds the maximum but by errors of double precision.

    Parameters
    ----------
    tails, heads, capacities
        (E,) arcs; capacities are not negative.
    source, sink
        The last two nodes.

    Returns
    -------
    flow, side
        Value of the flow; (n,) whether each node is on the source's side of the cut.
    """
    n = sink + 1
    # With every arc in both directions a flow has the same sparsity as its graph.
    both = np.concatenate([capacities, np.zeros(len(capacities))])
    arcs = np.concatenate([tails, heads]), np.concatenate([heads, tails])
    residual = sparse.csr_array((both, arcs), shape=(n, n))
    rows = np.repeat(np.arange(n), np.diff(residual.indptr))
    side = np.arange(n) == source
    value, first = 0.0, 0.0
    for _ in range(_MOST_ROUNDS):
        largest = float(residual.data[side[rows] & ~side[residual.indices]].sum())
        first, unit = max(first, largest), largest / _UNITS
        if not unit > 0.0 or largest <= _NEGLIGIBLE * first:
            break
        rounded = np.floor(np.minimum(residual.data, largest) / unit).astype(np.int32)
        graph = sparse.csr_array((rounded, residual.indices, residual.indptr), shape=(n, n))
        found = maximum_flow(graph, source, sink)
        value += found.flow_value * unit
        residual.data = np.maximum(residual.data - unit * found.flow.data, 0.0)
        left = rounded > found.flow.data
        side = _reachable(residual.indptr, residual.indices, left, source)
    return value, side


@kernel
def _reachable(
    first: npt.NDArray[np.int32], heads: npt.NDArray[np.int32], left: BoolArray, source: int
) -> BoolArray:
    """Nodes that are reached from the source by arcs with capacity left."""
    found = np.zeros(len(first) - 1, dtype=np.bool_)
    stack, count = np.full(len(found), source), 1
    found[source] = True
    while count:
        count -= 1
        node = stack[count]
        for arc in range(first[node], first[node + 1]):
            if left[arc] and not found[heads[arc]]:
                found[heads[arc]] = True
                stack[count] = heads[arc]
                count += 1
    return found
