"""Figures of third-order terms, and the distortion of a map by them."""

import numpy as np
import pytest

from bench.collection import KnownShape
from bench.third_order import Proven, distortion, figures_of
from solver.mesh import triangle_mesh
from solver.shape import Shape
from tests.solver import shapes


def test_figures() -> None:
    rows = [
        Proven(0.05, 0.6, True, 0.1),
        Proven(0.2, 0.6, True, 0.2),
        Proven(0.6, 0.1, True, 0.3),
        Proven(0.4, 0.5, False, 0.4),
    ]
    figures = figures_of(rows)
    assert figures["direct"] == 0.5
    assert figures["mirrored"] == 0.25
    assert figures["within_0_1"] == 0.25
    assert figures["proven"] == 0.75
    assert figures["most_seconds"] == 0.4


def test_a_mirror_image_has_four_times_the_mean_square() -> None:
    blob = shapes.blob()
    image = triangle_mesh(blob.vertices * [-1.0, 1.0, 1.0], blob.faces)
    source, copy, mirrored = (
        KnownShape("blob", "blob", Shape(mesh), None, None) for mesh in (blob, blob, image)
    )
    samples = np.array([0, 57, 121, 300, 411])
    assert distortion(source, copy, samples, samples) == pytest.approx(0.0, abs=1e-12)
    assert distortion(source, mirrored, samples, samples) == pytest.approx(4.0)
