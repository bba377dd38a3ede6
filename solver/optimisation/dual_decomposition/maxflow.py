"""The maxflow subproblem: candidates with their pairwise costs, but without constraints.

Minimising a quadratic function of binary variables is hard in general; its roof dual, the optimum
of the linear relaxation, is a minimum cut in a graph with two nodes for each variable, one for it
and one for its complement (Boros and Hammer, "Pseudo-Boolean optimization", 2002). The relaxed
variables are 0, 1/2 or 1.
"""

import numpy as np
from ortools.graph.python.max_flow import SimpleMaxFlow

from solver.arrays import FloatArray, IntArray
from solver.optimisation.dual_decomposition.shares import Used

_CAPACITY = float(2**53)
"""What the capacities add up to as integers, about: no flow overflows 64 bits."""


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
        (E,) what stands for x_a x_b in it.
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
        minimum itself. Capacities are rounded down to integers, so rounding never raises it.
        """
        count = len(self.unary)
        negative = self.pairwise < 0.0
        linear = 0.5 * self.unary
        np.add.at(linear, self._first[negative], 0.5 * self.pairwise[negative])
        tails, heads, capacities = self._arcs(linear, negative)
        scale = _CAPACITY / max(float(capacities.sum()), 1e-300)
        rounded = np.floor(capacities * min(scale, 1e300)).astype(np.int64)
        graph = SimpleMaxFlow()
        graph.add_arcs_with_capacity(tails, heads, rounded)
        source, sink = 2 * count, 2 * count + 1
        if graph.solve(source, sink) != graph.OPTIMAL:
            raise ArithmeticError("the maximum flow could not be computed")
        side = np.zeros(2 * count + 2, dtype=np.bool_)
        side[graph.get_source_side_min_cut()] = True
        self._label(side[:count], ~side[count : 2 * count], negative)
        constant = 2.0 * float(np.minimum(linear, 0.0).sum())
        return constant + float(graph.optimal_flow()) / scale

    def _arcs(
        self, linear: FloatArray, negative: np.ndarray[tuple[int], np.dtype[np.bool_]]
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Arcs of the doubled graph: node a is x_a, node V + a is y_a, which stands for 1 − x_a.

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
        return tails.astype(np.int64), heads.astype(np.int64), capacities

    def _label(
        self,
        taken: np.ndarray[tuple[int], np.dtype[np.bool_]],
        complement: np.ndarray[tuple[int], np.dtype[np.bool_]],
        negative: np.ndarray[tuple[int], np.dtype[np.bool_]],
    ) -> None:
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
