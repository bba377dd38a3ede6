"""Maps of all vertices from known points."""

from collections.abc import Sequence

from solver.arrays import IntArray
from solver.control import Control
from solver.functional_maps import DenseMap, select_map
from solver.shape import Shape


def dense_map(
    source: Shape,
    target: Shape,
    hypotheses: Sequence[tuple[IntArray, IntArray]],
    control: Control | None = None,
) -> DenseMap:
    """Best extension of corresponding vertices, without further maps."""
    found = select_map(source, target, hypotheses, control or Control(), further=False)
    assert found is not None
    return found
