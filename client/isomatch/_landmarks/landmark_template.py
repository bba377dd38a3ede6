"""Shapes with the landmarks that are carried to others."""

from dataclasses import dataclass

from isomatch._landmarks.landmark_set import LandmarkSet
from isomatch._models import Shape


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
    """

    shape: Shape | str
    landmarks: LandmarkSet
