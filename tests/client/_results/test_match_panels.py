"""Colours of the surfaces of a match."""

import numpy as np
from isomatch._figures import surface_colors
from isomatch._models import DenseCorrespondence, InverseCorrespondence
from isomatch._results.geometry import Geometry
from isomatch._results.match_panels import UNMAPPED, map_colors

SURFACE = Geometry(
    np.array([[0.0, 0, 0], [1.0, 0, 0], [0.0, 1, 0], [1.0, 1, 0]]),
    np.array([[0, 1, 2], [1, 3, 2]]),
    np.array([2, 3, 5, 8]),
    None,
)
FORWARD = DenseCorrespondence(hypothesis=0, source=(2, 3, 8), target=(3, 5, 8))


def grey(colors: np.ndarray) -> list[bool]:
    return [bool((color == UNMAPPED).all()) for color in colors]


def test_vertices_without_a_partner_are_grey_on_both_shapes() -> None:
    corners = ((2, 3, 5),) * 2
    weights = ((1.0, 0.0, 0.0),) * 2
    inverse = InverseCorrespondence(
        target=(3, 8), source=(2, 8), faces=corners, barycentric=weights
    )
    here, there = map_colors(FORWARD.model_copy(update={"inverse": inverse}), SURFACE, SURFACE)
    assert grey(here) == [False, False, True, False]
    assert grey(there) == [True, False, True, False]
    # The image of a vertex keeps its colour on the source, even without a preimage of its own.
    np.testing.assert_array_equal(here[[0, 1, 3]], surface_colors(SURFACE.vertices)[[1, 2, 3]])


def test_a_target_without_an_inverse_map_is_coloured() -> None:
    _, there = map_colors(FORWARD, SURFACE, SURFACE)
    np.testing.assert_array_equal(there, surface_colors(SURFACE.vertices))
