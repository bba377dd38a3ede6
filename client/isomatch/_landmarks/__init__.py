"""Landmarks: files of them, and their images on other specimens."""

from isomatch._landmarks.carrying import (
    CarriedLandmarks,
    carried_landmarks,
    with_same_labels,
)
from isomatch._landmarks.formats import (
    FORMATS,
    PER_SPECIMEN,
    CoordinateSystem,
    LandmarkFormat,
    append_landmarks,
    read_landmarks,
    stem_of,
    write_landmarks,
)
from isomatch._landmarks.landmark_set import LandmarkSet
from isomatch._landmarks.placing import LandmarkTemplate, PlacedLandmarks, Placements
from isomatch._landmarks.remarks import remarks_on

__all__ = [
    "FORMATS",
    "PER_SPECIMEN",
    "CarriedLandmarks",
    "CoordinateSystem",
    "LandmarkFormat",
    "LandmarkSet",
    "LandmarkTemplate",
    "PlacedLandmarks",
    "Placements",
    "append_landmarks",
    "carried_landmarks",
    "read_landmarks",
    "remarks_on",
    "stem_of",
    "with_same_labels",
    "write_landmarks",
]
