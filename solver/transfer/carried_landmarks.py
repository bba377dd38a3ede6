"""Landmarks carried along a map, and measures of how far it can be trusted there."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh
from solver.registration import DenseCorrespondence
from solver.transfer.landmark_confidence import local_distortion
from solver.transfer.landmarks import Landmarks, landmark_images


@dataclass(frozen=True, eq=False)
class CarriedLandmarks:
    """Images of those of n points that the map has, and measures of it.

    Parameters
    ----------
    rows
        (m,) which of the points have an image: all corners of their triangles have.
    images
        The m images, of the target.
    round_trip
        (m,) distance on the source between each point and the image of its image, over √area; nan
        where a corner of the image's triangle has no image itself, as at the edge of a part.
    distortion
        (m,) of :func:`.local_distortion`.
    """

    rows: IntArray
    images: Landmarks
    round_trip: FloatArray
    distortion: FloatArray


def carry_landmarks(
    points: Landmarks,
    maps: tuple[DenseCorrespondence, DenseCorrespondence],
    source: TriangleMesh,
    target: TriangleMesh,
    scale: float | None = None,
) -> CarriedLandmarks:
    """Carry points of X to Y, and measure the map there.

    Parameters
    ----------
    points
        Of X.
    maps
        X → Y and Y → X.
    source, target
        The surfaces X and Y.
    scale
        As for :func:`.local_distortion`.

    Raises
    ------
    TransferError
        Barycentric coordinates are negative or of another sum than 1.
    """
    there, back = maps
    rows = np.flatnonzero(points.among(there.source))
    carried = points.at(rows)
    images = landmark_images(carried, there, target)
    places = carried.positions(source)
    returning = images.among(back.source)
    returned = landmark_images(images.at(returning), back, source).positions(source)
    trips = np.full(len(rows), np.nan)
    trips[returning] = np.linalg.norm(returned - places[returning], axis=1) / np.sqrt(source.area)
    distortion = local_distortion(places, source, there, target, scale)
    return CarriedLandmarks(rows, images, trips, distortion)
