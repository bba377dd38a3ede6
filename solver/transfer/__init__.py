"""Transfer of values along a dense map: scalars, vectors, colours, labels, weights, landmarks.

:func:`carried` transfers an attribute of vertices or faces from one shape to the other;
:func:`landmark_images` maps points.
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
from solver.transfer.landmarks import Landmarks, landmark_images
from solver.transfer.overlap import CORNERS, FACES, VERTICES, Overlap, overlap_of
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
    "SCALARS",
    "SKINNING",
    "VECTORS",
    "VERTICES",
    "Along",
    "Attribute",
    "Landmarks",
    "Overlap",
    "PullBack",
    "baked_texture",
    "carried",
    "carried_paint",
    "landmark_images",
    "overlap_of",
    "selected",
    "texture_colors",
]
