"""Shapes that tests of registration share."""

import pytest

from solver.control import Control
from solver.registration.choice import COARSE, FINE, Candidate, Task, choose, from_hypotheses
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


@pytest.fixture(scope="session")
def found(blob: Shape) -> list[Candidate]:
    """Of a body and itself, the right one first."""
    task = Task.of(blob, blob)
    return choose(task, from_hypotheses(task, ()), (*COARSE, *FINE), Control())
