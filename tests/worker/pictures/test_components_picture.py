"""Pictures of components."""

import io

import matplotlib.image
import numpy as np
from scipy.spatial.transform import Rotation

from solver.arrays import FloatArray
from tests.worker.families import member
from worker.pictures import View, draw_components, source_view


def pixels(png: bytes) -> FloatArray:
    image: FloatArray = matplotlib.image.imread(io.BytesIO(png), format="png")
    return image


def test_the_mean_is_seen_as_the_view_says() -> None:
    vertices, faces = member(3)
    view = source_view(vertices, faces)
    steps, variances = 0.3 * vertices[None], np.array([1.0])
    lying = Rotation.from_euler("xyz", [70, 20, 10], degrees=True).as_matrix()
    standing = draw_components(vertices, faces, steps, variances, [0.9], "x", view)
    turned, other = (
        draw_components(vertices @ lying.T, faces, steps @ lying.T, variances, [0.9], "x", seen)
        for seen in (View(view.axes @ lying.T), view)
    )
    np.testing.assert_allclose(pixels(turned), pixels(standing), atol=0.02)
    assert np.abs(pixels(other) - pixels(standing)).max() > 0.1
