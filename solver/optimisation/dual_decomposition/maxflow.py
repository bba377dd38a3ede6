"""Maxflow subproblem: candidates with their pairwise costs, without constraints.

Minimising a quadratic function of binary variables is hard in general; its roof dual, the optimum
of the linear relaxation, is a minimum cut in a graph with two nodes for each variable, one for it
and one for its complement (Boros and Hammer, "Pseudo-Boolean optimization", 2002). The relaxed
variables are 0, 1/2 or 1.
"""

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.optimisation.dual_decomposition.exchange import Used
from solver.optimisation.minimum_cut import minimum_cut


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
