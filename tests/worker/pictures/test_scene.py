"""Shapes of a match in the coordinates of a picture."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from broker.contracts import Correspondence
from solver.mesh import triangle_mesh
from solver.prototype import PrototypeOptions, connected_examples, learn_prototype
from solver.shape import Shape
from synthetic import HUMAN_POSES, human
from worker.pictures.hypothesis import Hypothesis
from worker.pictures.scene import prototype_scenes


def test_a_prototype_is_drawn_on_its_reference_surface() -> None:
    """Matched with the shape it was learned from: both are drawn alike."""
    body = human(next(iter(HUMAN_POSES)), resolution=400)
    mesh = triangle_mesh(body.vertices, body.faces)
    options = PrototypeOptions(points=8, components=1)
    prototype = learn_prototype(connected_examples((Shape(mesh),), options).examples, options)
    pairs = tuple(
        Correspondence(source=point, target=vertex, cost=0.0)
        for point, vertex in enumerate(prototype.vertices.tolist())
    )
    answer = Hypothesis(pairs, None, None, "", "")
    for kept, rough in ((prototype, 0.05), (replace(prototype, surfaces=()), 1e-9)):
        left, right = prototype_scenes(kept, mesh, answer)
        assert (len(left.faces) > 0) == (kept is prototype)
        np.testing.assert_allclose(pdist(left.points), pdist(right.points), atol=rough)
        assert left.vertices[:, 0].max() < right.vertices[:, 0].min()
    assert float(np.ptp(left.points[:, 1])) == pytest.approx(float(np.ptp(right.points[:, 1])))
