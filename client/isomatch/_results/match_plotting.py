"""Figures of matches."""

from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from isomatch._models import Correspondences
from isomatch._results.geometry import Geometry
from isomatch._results.prototype_plotting import prototype_scene
from isomatch._results.prototype_points import PrototypePoints
from isomatch._results.result import Drawable
from isomatch._results.surface_plotting import Scene, plot_scenes, surface_colors

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from isomatch._models import DenseCorrespondence, Refinement
    from isomatch._results.match import Match

Floats = npt.NDArray[np.float64]

NOWHERE: Final = 0.8
"""Gray of vertices that a dense map leaves out."""


def plot_match(
    match: "Match", source: Drawable, target: Drawable, alternative: int | None = None
) -> "Figure":
    """Draw both sides of a match, what corresponds in common colours.

    Parameters
    ----------
    match
        The match.
    source, target
        The shapes, or the prototype and the shape.
    alternative
        Which answer: 0 for the match's own pairs, j for the j-th alternative; None for the one
        that was refined or extended, if one was.
    """
    assert isinstance(target, Geometry)
    which = _extended(match) if alternative is None else alternative
    answer = (match, *match.alternatives)[which]
    colors: tuple[Floats | None, Floats | None] = None, None
    title = f"{len(answer.pairs)} corresponding points"
    if alternative:
        title = f"alternative {alternative} of {len(match.alternatives)}: {title}"
    refined = None
    if match.refinement is not None and match.refinement.hypothesis == which:
        title, refined = title + ", refined between vertices", match.refinement
    here, there = _points(answer, refined, source, target)
    dense = match.dense
    if dense is not None and dense.hypothesis == which and isinstance(source, Geometry):
        colors = carried_colors(dense, source, target)
        title += ", and a map of all vertices"
    proof = "proven optimal" if match.certified else f"gap {match.gap:.2g}"
    if which:
        proof = f"of the match {match.energy:.4g}, {proof}"
    scenes = [
        _scene(source, here, colors[0], "source"),
        _scene(target, there, colors[1], "target"),
    ]
    return plot_scenes(scenes, f"{title}\nenergy {answer.energy:.4g}, {proof}")


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


def _extended(match: "Match") -> int:
    """Which answer was refined or extended: 0 for the match's own pairs, also if none was."""
    if match.refinement is not None:
        return match.refinement.hypothesis
    return 0 if match.dense is None else match.dense.hypothesis


def _points(
    answer: Correspondences, refined: "Refinement | None", source: Drawable, target: Geometry
) -> tuple[Floats, Floats]:
    """Where the matched points are."""
    if refined is None:
        pairs = answer.pairs
        return _places(source, pairs[:, 0]), target.positions(pairs[:, 1])
    corners = target.positions(refined.refined_vertices)
    there = np.einsum("nc,ncd->nd", refined.refined_weights, corners)
    return _places(source, refined.source_vertices), there


def _places(source: Drawable, numbers: npt.NDArray[np.int64]) -> Floats:
    if isinstance(source, Geometry):
        return source.positions(numbers)
    places: Floats = source.positions[numbers]
    return places


def _scene(shape: Drawable, points: Floats, colors: Floats | None, caption: str) -> Scene:
    if isinstance(shape, PrototypePoints):
        return prototype_scene(shape, points, "points of the prototype")
    return Scene(shape.vertices, points, shape.faces, colors, caption=caption)
