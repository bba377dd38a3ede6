"""Textures: decoding of images, and vertex colours sampled from them."""

from solver.mesh.textures.images import MOST_IMAGES, MOST_PIXELS, ImageBudget, Pixels
from solver.mesh.textures.light import display_values, linear_light, tinted
from solver.mesh.textures.material import Material
from solver.mesh.textures.painting import Paint, barycentric_pattern, painted_colors
from solver.mesh.textures.texture import Texture, Wrap

__all__ = [
    "MOST_IMAGES",
    "MOST_PIXELS",
    "ImageBudget",
    "Material",
    "Paint",
    "Pixels",
    "Texture",
    "Wrap",
    "barycentric_pattern",
    "display_values",
    "linear_light",
    "painted_colors",
    "tinted",
]
