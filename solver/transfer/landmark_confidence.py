"""Confidence of a carried landmark, from its match and from the map around it."""

from typing import Final

import numpy as np
import scipy.sparse as sp
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.mesh import TriangleMesh, nearest_rotations, triangle_areas
from solver.registration import DenseCorrespondence
from solver.transfer.landmarks import Landmarks

NEAR: Final = 0.05
"""Error over √area up to which a landmark counts as right."""

RADIUS: Final = 0.1
"""Radius over √area of the part of the surface whose distortion is measured."""

INTERCEPT: Final = -3.35
WEIGHTS: Final = (-0.326, -2.16)
"""Of the logarithms of round trip and local distortion, fitted by ``python -m bench.landmarks
--fit`` to generated pairs."""

_LEAST_TRIP: Final = 0.001
_LEAST_DISTORTION: Final = 0.01


def confidence_features(round_trip: FloatArray, distortion: FloatArray) -> FloatArray:
    """Return what the logit of a landmark in a right match is linear in, (n, 2).

    Parameters
    ----------
    round_trip
        (n,) distance of each landmark from the image of its image, over √area.
    distortion
        (n,) of :func:`local_distortion`.
    """
    return np.stack(
        [np.log(round_trip + _LEAST_TRIP), np.log(distortion + _LEAST_DISTORTION)], axis=1
    )


def landmark_confidence(
    probability: float, round_trip: FloatArray, distortion: FloatArray
) -> FloatArray:
    """Return the confidence of each landmark, (n,).

    It is the probability that the match is right, times the probability that a landmark is within
    `NEAR` √area of the right place if it is. The latter is a logistic regression. The product is at
    most the match's confidence: the map of a wrong match, such as the mirror image, may be as
    smooth as that of a right one.

    Parameters
    ----------
    probability
        Confidence of the match.
    round_trip, distortion
        As for :func:`confidence_features`; where one is nan, so is the confidence.
    """
    logits = INTERCEPT + confidence_features(round_trip, distortion) @ np.array(WEIGHTS)
    found: FloatArray = probability / (1.0 + np.exp(-logits))
    return found


def local_distortion(
    points: FloatArray,
    source: TriangleMesh,
    along: DenseCorrespondence,
    target: TriangleMesh,
    scale: float | None = None,
) -> FloatArray:
    """Measure how far a map is from a rigid motion around points, both shapes at one scale.

    The vertices of the part of the surface within `RADIUS` of a point, and their images, are
    brought together by the best rotation (Kabsch 1976); the measure is the root mean square
    distance that remains, over `RADIUS`: 0 for a rigid motion. Lengths are over the square root of
    the area that is mapped.

    Parameters
    ----------
    points
        (n, 3) on the source.
    source
        The surface that is mapped.
    along
        The map, of all its vertices or of a part of them.
    target
        The other surface.
    scale
        Factor from lengths of the source to lengths of the target; by default that of the square
        roots of the areas that are mapped and of the target, which it is not for a part.

    Returns
    -------
    (n,) float64; nan if no face is mapped.
    """
    mapped = np.zeros(source.n_vertices, dtype=np.bool_)
    mapped[source.vertices_of(along.source)] = True
    faces = source.faces[mapped[source.faces].all(axis=1)]
    if not len(faces):
        return np.full(len(points), np.nan)
    size = float(np.sqrt(triangle_areas(source.vertices, faces).sum()))
    scale = float(np.sqrt(target.area)) / size if scale is None else scale
    here, there = source.vertices / size, np.full((source.n_vertices, 3), np.nan)
    images = Landmarks(along.faces, along.barycentric).positions(target)
    there[source.vertices_of(along.source)] = images / (scale * size)
    first, neighbours = _neighbours(faces, source.n_vertices)
    used = np.unique(faces)
    nearest = used[KDTree(here[used]).query(points / size)[1]]
    part, reached = np.empty(len(here), dtype=np.int64), np.full(len(here), -1)
    residuals = np.empty(len(points))
    for place, point in enumerate(points / size):
        count = _part_around(point, nearest[place], here, first, neighbours, part, reached, place)
        residuals[place] = _rigid_residual(here[part[:count]], there[part[:count]])
    return residuals / RADIUS


def _rigid_residual(here: FloatArray, there: FloatArray) -> float:
    """Root mean square distance of points after the best rotation and translation."""
    a, b = here - here.mean(axis=0), there - there.mean(axis=0)
    (rotation,) = nearest_rotations((a.T @ b)[None])
    return float(np.sqrt(((a @ rotation - b) ** 2).sum(axis=1).mean()))


def _neighbours(faces: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Neighbours of vertex v over edges of (F, 3) faces: ``second[first[v]:first[v + 1]]``."""
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    both = np.concatenate([ends, ends[:, ::-1]]).T
    edges = sp.csr_array((np.ones(len(both[0])), (both[0], both[1])), shape=(count, count))
    return edges.indptr.astype(np.int64), edges.indices.astype(np.int64)


@kernel
def _part_around(
    point: FloatArray,
    nearest: int,
    vertices: FloatArray,
    first: IntArray,
    neighbours: IntArray,
    found: IntArray,
    reached: IntArray,
    mark: int,
) -> int:
    """Find the vertices within `RADIUS` of a point that hang together with the nearest one.

    The nearest vertex and its neighbours belong to the part, however far they are.

    Parameters
    ----------
    point
        (3,).
    nearest
        The vertex nearest to it.
    vertices
        (V, 3).
    first, neighbours
        Neighbours of vertex v are ``neighbours[first[v]:first[v + 1]]``.
    found
        (V,) to be overwritten with the vertices of the part.
    reached
        (V,) without `mark`, which is written for vertices of the part.
    mark
        A number.

    Returns
    -------
    The number of vertices found.
    """
    found[0], count = nearest, 1
    reached[nearest] = mark
    done = 0
    while done < count:
        here = found[done]
        for entry in range(first[here], first[here + 1]):
            other = neighbours[entry]
            if reached[other] == mark:
                continue
            square = 0.0
            for d in range(3):
                square += (vertices[other, d] - point[d]) ** 2
            if done == 0 or square <= RADIUS * RADIUS:
                reached[other] = mark
                found[count] = other
                count += 1
        done += 1
    return count
