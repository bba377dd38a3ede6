"""Holes are punched where they fit, and no more than asked for."""

import pytest

from synthetic import with_holes
from tests.solver import shapes


def test_as_many_holes_as_asked_for() -> None:
    found = with_holes(shapes.blob(), 3, 0.2)
    assert found.mesh.components == 1
    assert found.mesh.n_faces < shapes.blob().n_faces


def test_more_than_fit_are_refused_unless_fewer_will_do() -> None:
    blob = shapes.blob()
    with pytest.raises(ValueError, match="too thin"):
        with_holes(blob, 2, 100.0)
    assert with_holes(blob, 2, 100.0, least=0).mesh is blob
