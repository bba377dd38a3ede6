"""Maps between generated surfaces for tests of transfer."""

import numpy as np

from solver.control import Control
from solver.mesh import TriangleMesh
from solver.registration import DenseCorrespondence, register
from solver.shape import Shape
from solver.transfer import PullBack
from tests.solver import shapes

MESH = shapes.blob()
FINE = shapes.blob(4)


def registered(source: TriangleMesh, target: TriangleMesh) -> DenseCorrespondence:
    found = register(Shape(source), Shape(target), [], Control())
    assert found is not None
    return found.dense(Control())


def both_ways(source: TriangleMesh, target: TriangleMesh) -> tuple[PullBack, PullBack]:
    """Pull-backs of source values to the target, and of target values to the source."""
    dense = registered(source, target)
    assert dense.inverse is not None
    return PullBack.along(dense.inverse, target), PullBack.along(dense, source)


def random_pull_back(seed: int, vertices: int = 40, rows: int = 30) -> PullBack:
    random = np.random.default_rng(seed)
    corners = random.integers(0, rows, size=(vertices, 3))
    corners[0, 0] = rows - 1
    weights = random.dirichlet(np.ones(3), size=vertices)
    return PullBack(np.arange(vertices), corners, weights, vertices)
