"""Landmarks of a template on its surface, found once for all specimens."""

from collections.abc import MutableMapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isomatch._landmarks.confidence import square_root_of_area
from isomatch._landmarks.landmark_set import LandmarkSet
from isomatch._landmarks.remarks import refuse_wrong_coordinates
from isomatch._landmarks.surface_points import SurfacePoints, nearest_points
from isomatch._models import Shape
from isomatch._results import Geometry


@dataclass(frozen=True, eq=False)
class LandmarkTemplate:
    """A shape and the landmarks on it.

    Attributes
    ----------
    shape
        The shape or its id.
    landmarks
        In the coordinates of its file. Each stands for the nearest point of the surface, and is
        missing if that is farther than 0.05 times the square root of the area.
    surface
        Of the shape, as from ``client.geometry``; None to request it when it is needed.
    """

    shape: Shape | str
    landmarks: LandmarkSet
    surface: Geometry | None = None


@dataclass(frozen=True, eq=False)
class PlacedLandmarks:
    """Landmarks of a template, and the nearest points of its surface.

    Attributes
    ----------
    landmarks
        The landmarks, of which m are not missing.
    surface
        Of the template.
    size
        Square root of its area.
    nearest
        Points nearest to the m landmarks.
    apart
        Their distances from these over √area, (m,) float64.
    """

    landmarks: LandmarkSet
    surface: Geometry
    size: float
    nearest: SurfacePoints
    apart: npt.NDArray[np.float64]

    @classmethod
    def of(cls, landmarks: LandmarkSet, surface: Geometry) -> "PlacedLandmarks":
        """Place landmarks on the surface of their template.

        Raises
        ------
        WrongCoordinates
            They are in another coordinate system than the surface.
        """
        refuse_wrong_coordinates(landmarks, surface)
        size = square_root_of_area(surface)
        given = landmarks.positions[landmarks.present]
        nearest = nearest_points(surface, given)
        apart = np.linalg.norm(given - nearest.positions(surface), axis=1) / size
        return cls(landmarks, surface, size, nearest, apart)


Placements: TypeAlias = MutableMapping[LandmarkTemplate, PlacedLandmarks]
"""Templates whose landmarks are placed."""
