"""Landmarks: files of them, and their images on other specimens."""

from isomatch._landmarks.carrying import (
    CarriedLandmarks,
    FromTemplate,
    from_transfer,
    merged,
    missing_landmarks,
    same_order,
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
from isomatch._landmarks.landmark_template import LandmarkTemplate
from isomatch._landmarks.remarks import remarks_on

__all__ = [
    "FORMATS",
    "PER_SPECIMEN",
    "CarriedLandmarks",
    "CoordinateSystem",
    "FromTemplate",
    "LandmarkFormat",
    "LandmarkSet",
    "LandmarkTemplate",
    "append_landmarks",
    "from_transfer",
    "merged",
    "missing_landmarks",
    "read_landmarks",
    "remarks_on",
    "same_order",
    "stem_of",
    "with_same_labels",
    "write_landmarks",
]
