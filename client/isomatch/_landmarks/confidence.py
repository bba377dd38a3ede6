"""Confidence of a carried landmark, from its match and from the map around it."""

from typing import Final

import numpy as np
import numpy.typing as npt

from isomatch._models import VertexMap
from isomatch._results import Geometry

Floats = npt.NDArray[np.float64]

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


def features(round_trip: Floats, distortion: Floats) -> Floats:
    """Return what the logit of a landmark in a right match is linear in, (n, 2).

    Parameters
    ----------
    round_trip
        Distance of each landmark from the image of its image, over √area, (n,).
    distortion
        Of :func:`local_distortion`, (n,).
    """
    return np.stack(
        [np.log(round_trip + _LEAST_TRIP), np.log(distortion + _LEAST_DISTORTION)], axis=1
    )


def confidence(probability: float, round_trip: Floats, distortion: Floats) -> Floats:
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
        As for :func:`features`.
    """
    logits = INTERCEPT + features(round_trip, distortion) @ np.array(WEIGHTS)
    found: Floats = probability / (1.0 + np.exp(-logits))
    return found


def local_distortion(
    template: Geometry,
    along: VertexMap,
    specimen: Geometry,
    points: Floats,
    scale: float | None = None,
) -> Floats:
    """Measure how far the map is from a rigid motion around points, both shapes at one scale.

    The vertices of the part of the surface within `RADIUS` of a point, and their images, are
    brought together by the best rotation (Kabsch 1976); the measure is the root mean square
    distance that remains, over `RADIUS`: 0 for a rigid motion.

    Parameters
    ----------
    template
        The surface that is mapped; its vertices are those of `along`.
    along
        The map.
    specimen
        The other surface.
    points
        On the template, (n, 3).
    scale
        Factor from lengths of the template to lengths of the specimen, by default that of their
        √area: not so if one is a part of the other.
    """
    size = square_root_of_area(template)
    scale = square_root_of_area(specimen) / size if scale is None else scale
    here = template.positions(along.vertices) / size
    corners = specimen.positions(along.faces) / (scale * size)
    there = np.einsum("kc,kcd->kd", along.weights, corners)
    faces = np.searchsorted(along.vertices, template.vertex_ids[template.faces])
    found = []
    for point in points / size:
        inside = _part_around(here, faces, point)
        found.append(_rigid_residual(here[inside], there[inside]) / RADIUS)
    return np.array(found, dtype=np.float64)


def square_root_of_area(geometry: Geometry) -> float:
    """Return the unit of relative lengths."""
    a, b, c = np.moveaxis(geometry.vertices[geometry.faces], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    return float(np.sqrt(area))


def _part_around(
    vertices: Floats, faces: npt.NDArray[np.int64], point: Floats
) -> npt.NDArray[np.int64]:
    """Vertices within `RADIUS` of a point that hang together with the nearest one."""
    distances = np.linalg.norm(vertices - point, axis=1)
    ball = distances <= RADIUS
    near = faces[ball[faces].any(axis=1)]
    # The nearest face belongs to the part, however large it is. Vertices of parts may have none.
    nearest = faces.flat[distances[faces].argmin()]
    reached = np.zeros(len(vertices), dtype=np.bool_)
    reached[faces[(faces == nearest).any(axis=1)]] = True
    while True:
        touched = near[reached[near].any(axis=1)]
        grown = reached.copy()
        grown[touched[ball[touched]]] = True
        if (grown == reached).all():
            return np.flatnonzero(reached)
        reached = grown


def _rigid_residual(here: Floats, there: Floats) -> float:
    """Root mean square distance of points after the best rotation and translation."""
    a, b = here - here.mean(axis=0), there - there.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    u[:, 2] *= np.sign(np.linalg.det(u @ vt))
    return float(np.sqrt(((a @ u @ vt - b) ** 2).sum(axis=1).mean()))
