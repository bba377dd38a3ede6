"""Figures of matches."""

from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from isomatch._geometry import Geometry
from isomatch._prototype_plotting import prototype_scene
from isomatch._prototype_points import PrototypePoints
from isomatch._result import Drawable
from isomatch._surface_plotting import Scene, plot_scenes, surface_colors

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from isomatch._dense import DenseCorrespondence
    from isomatch._match import Match

Floats = npt.NDArray[np.float64]

NOWHERE: Final = 0.8
"""Gray of vertices that a dense map leaves out."""


def plot_match(match: "Match", source: Drawable, target: Drawable) -> "Figure":
    """Draw both sides of a match, what corresponds in common colours.

    Parameters
    ----------
    match
        The match.
    source, target
        The shapes, or the prototype and the shape.
    """
    assert isinstance(target, Geometry)
    here, there = _points(match, source, target)
    colors: tuple[Floats | None, Floats | None] = None, None
    title = f"{len(here)} corresponding points"
    if match.refinement is not None:
        title += ", refined between vertices"
    if match.dense is not None and isinstance(source, Geometry):
        colors = carried_colors(match.dense, source, target)
        title += ", and a map of all vertices"
    proof = "proven optimal" if match.certified else f"gap {match.gap:.2g}"
    scenes = [
        _scene(source, here, colors[0], "source"),
        _scene(target, there, colors[1], "target"),
    ]
    return plot_scenes(scenes, f"{title}\nenergy {match.energy:.4g}, {proof}")


def carried_colors(
    dense: "DenseCorrespondence", source: Geometry, target: Geometry
) -> tuple[Floats, Floats]:
    """Return colours of the vertices of both, such that each has that of the vertex it goes to.

    Parameters
    ----------
    dense
        The map.
    source, target
        The shapes.

    Returns
    -------
    (V, 3) of the source's vertices, gray where the map says nothing, and (W, 3) of the target's.
    """
    there = surface_colors(target.vertices)
    here = np.full((len(source.vertices), 3), NOWHERE)
    here[source.rows(dense.source)] = there[target.rows(dense.target)]
    return here, there


def _points(match: "Match", source: Drawable, target: Geometry) -> tuple[Floats, Floats]:
    """Where the matched points are: of the hypothesis that was refined or extended, if one was."""
    if match.refinement is not None:
        there = np.einsum(
            "nc,ncd->nd",
            match.refinement.refined_weights,
            target.positions(match.refinement.refined_vertices),
        )
        return _places(source, match.refinement.source_vertices), there
    which = 0 if match.dense is None else match.dense.hypothesis
    pairs = (match, *match.alternatives)[which].pairs
    return _places(source, pairs[:, 0]), target.positions(pairs[:, 1])


def _places(source: Drawable, numbers: npt.NDArray[np.int64]) -> Floats:
    if isinstance(source, Geometry):
        return source.positions(numbers)
    places: Floats = source.positions[numbers]
    return places


def _scene(shape: Drawable, points: Floats, colors: Floats | None, caption: str) -> Scene:
    if isinstance(shape, PrototypePoints):
        return prototype_scene(shape, points, "points of the prototype")
    return Scene(shape.vertices, points, shape.faces, colors, caption=caption)
