"""Colours of figures."""

import numpy as np

from solver.mesh import TriangleMesh
from synthetic import articulated
from synthetic.texture import painted


def test_paint_is_smooth_and_symmetric_only_when_asked() -> None:
    shape = articulated("cat", "standing", 800)
    mirrored = shape.rest * np.array([-1.0, 1.0, 1.0])
    ends = TriangleMesh(shape.vertices, shape.faces, np.arange(800)).edges
    for symmetric in (False, True):
        colors = painted(shape.rest, symmetric)
        assert colors.min() >= 0.0
        assert colors.max() <= 1.0
        assert colors.std(axis=0).min() > 0.05
        steps = np.linalg.norm(colors[ends[:, 0]] - colors[ends[:, 1]], axis=1)
        lengths = np.linalg.norm(shape.rest[ends[:, 0]] - shape.rest[ends[:, 1]], axis=1)
        assert (steps < 4.5 * lengths).all()
    difference = painted(shape.rest) - painted(mirrored)
    aside = np.abs(shape.rest[:, 0]) > 0.08
    assert np.linalg.norm(difference[aside], axis=1).min() > 0.02
    np.testing.assert_allclose(painted(shape.rest, True), painted(mirrored, True), atol=1e-12)
