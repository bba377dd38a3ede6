"""Minimum cuts against SciPy's flows of whole numbers, and against duality with real capacities."""

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.optimisation.minimum_cut import minimum_cut

Graph = tuple[IntArray, IntArray, FloatArray]

NODES, ARCS = 30, 120
SOURCE, SINK = NODES - 2, NODES - 1


def graph(seed: int) -> Graph:
    """Arcs of capacities up to 100, some of them parallel, some opposite, and some of none."""
    rng = np.random.default_rng(seed)
    tails, heads = rng.integers(0, NODES, size=(2, ARCS))
    return tails, heads, np.maximum(100.0 * rng.random(ARCS) - 10.0, 0.0)


def of_scipy(tails: IntArray, heads: IntArray, capacities: FloatArray) -> tuple[float, BoolArray]:
    """Flow of whole capacities, and what its residual network reaches from the source."""
    whole = capacities.astype(np.int32)
    network = sparse.csr_array((whole, (tails, heads)), shape=(NODES, NODES))
    found = maximum_flow(network, SOURCE, SINK)
    left = sparse.csr_array(network - found.flow)
    left.eliminate_zeros()
    reached = np.zeros(NODES, dtype=np.bool_)
    reached[breadth_first_order(left, SOURCE, return_predecessors=False)] = True
    return float(found.flow_value), reached


@pytest.mark.parametrize("seed", range(20))
def test_whole_capacities_are_cut_as_by_scipy(seed: int) -> None:
    tails, heads, capacities = graph(seed)
    apart = tails != heads
    whole = tails[apart], heads[apart], np.floor(capacities[apart])
    flow, side = minimum_cut(*whole, SOURCE, SINK)
    expected, reached = of_scipy(*whole)
    assert flow == expected
    np.testing.assert_array_equal(side, reached)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("seed", range(20))
def test_the_flow_is_the_capacity_of_the_cut(seed: int, scale: float) -> None:
    """No flow is greater than a cut, so that both are optimal."""
    tails, heads, capacities = graph(seed)
    flow, side = minimum_cut(tails, heads, scale * capacities, SOURCE, SINK)
    assert side[SOURCE]
    assert not side[SINK]
    cut = scale * capacities[side[tails] & ~side[heads]].sum()
    assert flow == pytest.approx(cut, rel=1e-9)


def test_without_a_path_nothing_flows() -> None:
    nothing = np.zeros(0, dtype=np.int64)
    flow, side = minimum_cut(nothing, nothing, np.zeros(0), 1, 2)
    assert flow == 0.0
    np.testing.assert_array_equal(side, [False, True, False])
