"""Files of landmarks: Slicer markups (JSON and FCSV), TPS, MorphoJ, and tables of points."""

from isomatch._landmarks.formats.files import (
    FORMATS,
    PER_SPECIMEN,
    LandmarkFormat,
    append_landmarks,
    read_landmarks,
    stem_of,
    write_landmarks,
)
from isomatch._landmarks.formats.reading import CoordinateSystem

__all__ = [
    "FORMATS",
    "PER_SPECIMEN",
    "CoordinateSystem",
    "LandmarkFormat",
    "append_landmarks",
    "read_landmarks",
    "stem_of",
    "write_landmarks",
]
