"""Error of a dense map against the known truth, by the Princeton protocol.

Geodesic distance on the target between the image of a point and its true partner, over √area. The
*direct* truth is that of the anatomy; the mirrored one exchanges left and right. An answer is wrong
if its mean error to the direct truth is above `WRONG`.
"""

from dataclasses import dataclass

import numpy as np

from bench.collection import KnownShape
from bench.surface_error import corner_errors, surface_errors
from solver.arrays import FloatArray, IntArray
from solver.gmds import SurfacePoints
from solver.registration import DenseCorrespondence

WRONG = 0.1
"""Mean error over √area above which an answer counts as wrong."""

MIRRORED = 0.8
"""Share of the direct error below which the mirrored one must be to call an answer mirrored."""

WITHIN = 0.05, 0.1, 0.25
"""Errors of which the share of points within them is reported."""

COMPARED = 500
"""Known points that are compared, at most."""


@dataclass(frozen=True)
class MapError:
    """Errors of one map, mean over the points compared, over √area.

    Parameters
    ----------
    direct
        Of the images on the surface, between vertices, to the direct truth.
    at_vertices
        The same, of the vertices nearest to the images.
    better
        The lesser of the direct and the mirrored error; the direct one where nobody knows the
        symmetry.
    within
        Share of points whose direct error is at most that of each of `WITHIN`.
    """

    direct: float
    at_vertices: float
    better: float
    within: tuple[float, ...]

    @property
    def right(self) -> bool:
        """Whether the answer counts as right."""
        return self.direct <= WRONG

    @property
    def mirrored(self) -> bool:
        """Whether the answer is nearer to the mirrored truth."""
        return self.better < MIRRORED * self.direct


def known_points(
    source: KnownShape, target: KnownShape, most: int = COMPARED
) -> tuple[IntArray, list[IntArray]]:
    """Vertices of the source whose partners are known, evenly among these.

    Parameters
    ----------
    source, target
        Shapes of one class, both with known truth; -1 stands for a point that a shape lacks.
    most
        Greatest number of points, but for rounding.

    Returns
    -------
    vertices
        (N,) vertex indices of the source.
    truths
        One or two arrays of (N,) vertex indices of the target: direct, and mirrored if known.
    """
    assert source.truth is not None
    assert target.truth is not None
    here = source.truth >= 0
    known = [truth for truth in (target.truth, target.symmetric_truth) if truth is not None]
    places = np.flatnonzero(here & np.all([truth >= 0 for truth in known], axis=0))
    places = places[:: max(len(places) // most, 1)]
    return source.truth[places], [truth[places] for truth in known]


def map_error(
    source: KnownShape, target: KnownShape, dense: DenseCorrespondence, most: int = COMPARED
) -> MapError:
    """Compare a dense map with the truth.

    Parameters
    ----------
    source, target
        Shapes of one class, both with known truth.
    dense
        Map between them, in the user's vertex numbers. Points that it leaves out are not compared.
    most
        How many points are compared, evenly among those known.
    """
    vertices, truths = known_points(source, target, most)
    numbers = source.shape.mesh.vertex_ids[vertices]
    mapped = np.isin(numbers, dense.source)
    truths = [truth[mapped] for truth in truths]
    rows = np.searchsorted(dense.source, numbers[mapped])
    mesh = target.shape.mesh
    corners = mesh.vertices_of(dense.faces[rows].ravel()).reshape(-1, 3)
    nearest = mesh.vertices_of(dense.target[rows])
    return image_error(target, corners, dense.barycentric[rows], nearest, truths)


def image_error(
    target: KnownShape,
    corners: IntArray,
    barycentric: FloatArray,
    nearest: IntArray,
    truths: list[IntArray],
) -> MapError:
    """Compare images on a surface with the truth.

    Parameters
    ----------
    target
        Where the images are.
    corners, barycentric
        (N, 3) vertex indices of the triangle of each image, and (N, 3) coordinates in it.
    nearest
        (N,) vertex index nearest to each image.
    truths
        One or two arrays of (N,) vertex indices: direct, and mirrored if known.
    """
    errors = [corner_errors(target, corners, barycentric, truth) for truth in truths]
    means = [float(one.mean()) for one in errors]
    at_vertices = SurfacePoints.at_vertices(target.shape.surface, nearest)
    return MapError(
        direct=means[0],
        at_vertices=float(surface_errors(target, at_vertices, truths[0]).mean()),
        better=min(means),
        within=tuple(float((errors[0] <= bound).mean()) for bound in WITHIN),
    )


def vertex_errors(
    source: KnownShape, target: KnownShape, images: IntArray, most: int = COMPARED
) -> FloatArray:
    """(N,) errors over √area to the direct truth of a map given as (V,) vertices of the target."""
    vertices, truths = known_points(source, target, most)
    points = SurfacePoints.at_vertices(target.shape.surface, images[vertices])
    return surface_errors(target, points, truths[0])


def error_figures(errors: list[MapError]) -> dict[str, float]:
    """Figures of errors over pairs, for a line of JSON."""
    direct = np.array([one.direct for one in errors])
    better = np.array([one.better for one in errors])
    within = np.array([one.within for one in errors]).mean(axis=0)
    return {
        "pairs": len(errors),
        "direct": float(direct.mean()),
        "median_direct": float(np.median(direct)),
        "direct_over_0_1": float((direct > WRONG).mean()),
        "direct_at_vertices": float(np.mean([one.at_vertices for one in errors])),
        "within_0_05": float(within[0]),
        "within_0_10": float(within[1]),
        "within_0_25": float(within[2]),
        "best": float(better.mean()),
        "median_best": float(np.median(better)),
        "share_over_0_1": float((better > WRONG).mean()),
        "mirrored": float(np.mean([one.mirrored for one in errors])),
    }
