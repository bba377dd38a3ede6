"""Textures: images on a surface, and the colours that they give its vertices."""

from solver.textures.images import ImageBudget
from solver.textures.light import display_values, linear_light
from solver.textures.painting import Paint, painted_colors
from solver.textures.texture import Texture, Wrap

__all__ = [
    "ImageBudget",
    "Paint",
    "Texture",
    "Wrap",
    "display_values",
    "linear_light",
    "painted_colors",
]
