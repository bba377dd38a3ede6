"""Transfer of values along a dense map: scalars, vectors, colours, labels, weights, landmarks.

:func:`carried` transfers an attribute of vertices or faces from one shape to the other;
:func:`carry_landmarks` maps points, and measures the map there.
"""

from solver.transfer.attributes import (
    COLORS,
    COLORS_NAME,
    KINDS,
    LABELS,
    SCALARS,
    SKINNING,
    VECTORS,
    Along,
    Attribute,
    carried,
    selected,
)
from solver.transfer.carried_landmarks import CarriedLandmarks, carry_landmarks
from solver.transfer.landmark_confidence import (
    NEAR,
    confidence_features,
    landmark_confidence,
    local_distortion,
)
from solver.transfer.landmarks import Landmarks, landmark_images
from solver.transfer.overlap import CORNERS, FACES, VERTICES, Overlap, overlap_of
from solver.transfer.placement import PlacedLandmarks, landmark_name, place_landmarks
from solver.transfer.pull_back import PullBack
from solver.transfer.texture import baked_texture, texture_colors
from solver.transfer.texture_coordinates import carried_paint

__all__ = [
    "COLORS",
    "COLORS_NAME",
    "CORNERS",
    "FACES",
    "KINDS",
    "LABELS",
    "NEAR",
    "SCALARS",
    "SKINNING",
    "VECTORS",
    "VERTICES",
    "Along",
    "Attribute",
    "CarriedLandmarks",
    "Landmarks",
    "Overlap",
    "PlacedLandmarks",
    "PullBack",
    "baked_texture",
    "carried",
    "carried_paint",
    "carry_landmarks",
    "confidence_features",
    "landmark_confidence",
    "landmark_images",
    "landmark_name",
    "local_distortion",
    "overlap_of",
    "place_landmarks",
    "selected",
    "texture_colors",
]
