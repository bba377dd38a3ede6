"""Shapes that tests of registration share."""

import pytest

from solver.registration.surface import SmoothSurface, smooth_surface
from solver.shape import Shape
from tests.solver import shapes


@pytest.fixture(scope="session")
def blob() -> Shape:
    """A body without symmetry."""
    return Shape(shapes.blob())


@pytest.fixture(scope="session")
def surface(blob: Shape) -> SmoothSurface:
    return smooth_surface(blob)
