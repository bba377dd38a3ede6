"""Landmarks carried along a map, and measures of how far it can be trusted there."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh
from solver.registration import DenseCorrespondence
from solver.transfer.landmark_confidence import local_distortion
from solver.transfer.landmarks import Landmarks, landmark_images


@dataclass(frozen=True, eq=False)
class CarriedLandmarks:
    """Images of n points, and measures of the map there.

    Parameters
    ----------
    images
        On the target; missing where a corner of the point's triangle has no image.
    round_trip
        (n,) distance on the source between each point and the image of its image, over √area; nan
        without an image, or where a corner of the image's triangle has none itself, as at the edge
        of a part.
    distortion
        (n,) of :func:`.local_distortion`; nan without an image.
    """

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
        Of X, some of which may be missing.
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
    count = len(points.corners)
    rows = np.flatnonzero(points.among(there.source))
    carried = points.at(rows)
    found = landmark_images(carried, there, target)
    places = carried.positions(source)
    distortion = np.full(count, np.nan)
    distortion[rows] = local_distortion(places, source, there, target, scale)
    returning = found.among(back.source)
    returned = landmark_images(found.at(returning), back, source).positions(source)
    trips = np.linalg.norm(returned - places[returning], axis=1) / np.sqrt(source.area)
    round_trip = np.full(count, np.nan)
    round_trip[rows[returning]] = trips
    return CarriedLandmarks(Landmarks.at_rows(rows, found, count), round_trip, distortion)
