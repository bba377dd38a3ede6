"""Source and target of a match as they are drawn."""

from typing import Final

import numpy as np

from isomatch._figures import Floats, Indices, Panel, surface_colors
from isomatch._models import Correspondences, DenseCorrespondence, Refinement
from isomatch._results.geometry import Geometry
from isomatch._results.result_document import Drawable

UNMAPPED: Final = 0.8
"""Gray level of vertices that a dense map leaves out."""


def match_panels(
    answer: Correspondences,
    refinement: Refinement | None,
    dense: DenseCorrespondence | None,
    source: Drawable,
    target: Geometry,
) -> tuple[Panel, Panel]:
    """Return the panels of source and target.

    Parameters
    ----------
    answer
        The matched pairs.
    refinement
        Refined points of the same pairs, drawn instead of target vertices; None for none.
    dense
        Dense map of the same pairs, which colours both surfaces; None for none.
    source, target
        The shapes, or the prototype and the shape.
    """
    if refinement is None:
        numbers, target_numbers = answer.pairs.T
        there = target.positions(target_numbers)
    else:
        numbers, target_numbers = refinement.source_vertices, answer.pairs[:, 1]
        corners = target.positions(refinement.refined_vertices)
        there = np.einsum("nc,ncd->nd", refinement.refined_weights, corners)
    colors: tuple[Floats | None, Floats | None] = None, None
    if dense is not None and isinstance(source, Geometry):
        colors = map_colors(dense, source, target)
    return (
        _source_panel(source, numbers, colors[0]),
        Panel(
            target.vertices,
            there,
            target_numbers,
            faces=target.faces,
            colors=colors[1],
            caption="target",
            is_cloud=target.is_cloud,
        ),
    )


def map_colors(
    dense: DenseCorrespondence, source: Geometry, target: Geometry
) -> tuple[Floats, Floats]:
    """Return vertex colours such that source vertices have the colour of their target vertices.

    Parameters
    ----------
    dense
        The map.
    source, target
        The shapes.

    Returns
    -------
    (V, 3) of the source's vertices, gray where the map is undefined, and (W, 3) of the target's,
    gray where its inverse is undefined, if it has one.
    """
    there = surface_colors(target.vertices)
    here = np.full((len(source.vertices), 3), UNMAPPED)
    here[source.rows(dense.source)] = there[target.rows(dense.target)]
    if dense.inverse is not None:
        alone = np.ones(len(there), dtype=bool)
        alone[target.rows(dense.inverse.target)] = False
        there[alone] = UNMAPPED
    return here, there


def _source_panel(source: Drawable, numbers: Indices, colors: Floats | None) -> Panel:
    if not isinstance(source, Geometry):
        return source.panel(numbers)
    points = source.positions(numbers)
    return Panel(
        source.vertices,
        points,
        numbers,
        faces=source.faces,
        colors=colors,
        caption="source",
        view=source.view,
        is_cloud=source.is_cloud,
    )
