"""Pictures of components: the mean is seen as the template is."""

import io

import matplotlib.image
import numpy as np
from scipy.spatial.transform import Rotation

from solver.arrays import FloatArray
from tests.worker.families import member
from worker.pictures import draw_components


def pixels(png: bytes) -> FloatArray:
    image: FloatArray = matplotlib.image.imread(io.BytesIO(png), format="png")
    return image


def test_the_mean_stands_as_the_template() -> None:
    vertices, faces = member(3)
    template = np.arange(len(vertices)), vertices
    steps, variances = 0.3 * vertices[None], np.array([1.0])
    lying = Rotation.from_euler("xyz", [70, 20, 10], degrees=True).as_matrix()
    standing = draw_components(vertices, faces, steps, variances, [0.9], "x", template)
    turned = draw_components(
        vertices @ lying.T, faces, steps @ lying.T, variances, [0.9], "x", template
    )
    other = draw_components(vertices @ lying.T, faces, steps @ lying.T, variances, [0.9], "x")
    np.testing.assert_allclose(pixels(turned), pixels(standing), atol=0.02)
    assert np.abs(pixels(other) - pixels(standing)).max() > 0.1
