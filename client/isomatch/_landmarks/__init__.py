"""Landmarks: files of them."""

from isomatch._landmarks.formats import (
    FORMATS,
    PER_SPECIMEN,
    CoordinateSystem,
    LandmarkFormat,
    read_landmarks,
    stem_of,
    write_landmarks,
)
from isomatch._landmarks.landmark_set import LandmarkSet

__all__ = [
    "FORMATS",
    "PER_SPECIMEN",
    "CoordinateSystem",
    "LandmarkFormat",
    "LandmarkSet",
    "read_landmarks",
    "stem_of",
    "write_landmarks",
]
