"""A square on which a ramp of red and green is painted, and what its colours are."""

import numpy as np

from solver.arrays import BoolArray, FloatArray
from solver.mesh import TriangleMesh
from tests.solver.mesh.textures.textured_files import grid, image_file, ramp, textured_obj

VERTICES, FACES = grid(8)
UV = VERTICES[:, :2]
RAMP = image_file(ramp())
OBJ = textured_obj(VERTICES, FACES, UV)
INNER: BoolArray = np.all((UV > 0.05) & (UV < 0.95), axis=1)


def colors_of(mesh: TriangleMesh) -> FloatArray:
    assert mesh.colors is not None
    return mesh.colors


def on_ramp(coordinates: FloatArray) -> FloatArray:
    """Red and green of the ramp, v downwards."""
    return (coordinates * 256 - 0.5) / 255.0
