"""Textures carried along a map: as colours of vertices, or baked into an image of their own.

The image has a square for every two triangles of the surface, so that no texture coordinates of
that surface are needed, and seams of the first texture leave no trace.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh
from solver.mesh.textures import Paint, Texture, Wrap, tinted
from solver.registration import DenseCorrespondence
from solver.transfer.landmarks import Landmarks, surface_images
from solver.transfer.overlap import in_chunks, mapped_faces
from solver.transfer.texture_coordinates import faces_at_centres, with_materials

_LARGEST = 2048
"""Greatest width of a baked image, in texels, unless the least squares need more.

They do from 335,000 triangles on.
"""

_CELL = 5, 64
"""Least and greatest width of a square: two triangles of at least three texels a side."""

_FINER = 1.5
"""Width of a baked image over that of the textures: squares leave some of it unused."""


def texture_colors(
    points: Landmarks, dense: DenseCorrespondence, source: TriangleMesh, paint: Paint
) -> FloatArray:
    """Sample the texture of X at the images of points of Y.

    Parameters
    ----------
    points
        (n,) points of Y.
    dense
        The map Y → X.
    source
        The surface X with all faces of its file: :func:`solver.mesh.textured_surface`.
    paint
        The textures of its faces.

    Returns
    -------
    (n, 3) display values in 0..1.

    Raises
    ------
    TransferError
        A point is not part of the mapped surface.
    """
    faces, barycentric = surface_images(points, dense, source)
    colors = paint.colors[faces].astype(np.float64)
    coordinates = np.einsum("nc,ncd->nd", barycentric, paint.coordinates[faces])
    of_point = paint.texture_of_face[faces]
    for number, texture in enumerate(paint.textures):
        chosen = np.flatnonzero(of_point == number)
        light = np.ones(3) if paint.light is None else paint.light[faces[chosen]]
        colors[chosen] = tinted(texture.sample(coordinates[chosen]), light)
    return colors.clip(0.0, 1.0)


def baked_texture(
    target: TriangleMesh, dense: DenseCorrespondence, source: TriangleMesh, paint: Paint
) -> Paint:
    """Bake the texture of X into an image for the triangles of Y.

    Parameters
    ----------
    target
        The surface Y.
    dense, source, paint
        As for :func:`texture_colors`.

    Returns
    -------
    One texture, and texture coordinates of the faces of Y, whose materials are those that their
    centres are mapped to. Triangles with a corner that is not mapped are black.
    """
    side = int(np.ceil(np.sqrt((target.n_faces + 1) // 2)))
    texels = np.sqrt(sum(float(np.prod(one.size)) for one in paint.textures))
    cell = int(np.clip(_power_of_two(min(_FINER * texels, _LARGEST)) // side, *_CELL))
    width = _power_of_two(side * cell)
    pixels = np.zeros((width, width, 3), dtype=np.uint8)
    places, weights = _pattern(cell)
    for faces in in_chunks(mapped_faces(target, dense), len(places)):
        corners = target.vertex_ids[target.faces[faces]]
        points = Landmarks(
            np.repeat(corners, len(places), axis=0), np.tile(weights, (len(faces), 1))
        )
        found = np.rint(255.0 * texture_colors(points, dense, source, paint)).astype(np.uint8)
        x, y = (np.moveaxis(_in_image(faces, places, cell, side), -1, 0)).reshape(2, -1)
        pixels[y, x] = found
    every = np.arange(target.n_faces)
    corners = np.array([(0, 0), (cell - 3, 0), (0, cell - 3)], dtype=np.int64)
    centres = _in_image(every, corners, cell, side) + 0.5
    baked = Paint(
        centres / width,
        np.zeros((target.n_faces, 3)),
        np.zeros(target.n_faces, dtype=np.int64),
        (Texture(pixels, (Wrap.CLAMP, Wrap.CLAMP)),),
    )
    return with_materials(baked, paint, *faces_at_centres(target, dense, source))


def _power_of_two(size: float) -> int:
    """Least power of two that is as large: some programs want such images."""
    return 1 << int(np.ceil(np.log2(size)))


def _pattern(cell: int) -> tuple[IntArray, FloatArray]:
    """(n, 2) texels of a triangle in its half of a square, and (n, 3) their points.

    Texels beyond the long side belong to its border, for interpolation.
    """
    x, y = np.meshgrid(np.arange(cell), np.arange(cell), indexing="ij")
    inside = x + y <= cell - 2
    places = np.stack([x[inside], y[inside]], axis=1)
    two = places / (cell - 3.0)
    weights = np.column_stack([1.0 - two.sum(axis=1), two]).clip(0.0)
    return places, weights / weights.sum(axis=1, keepdims=True)


def _in_image(faces: IntArray, places: IntArray, cell: int, side: int) -> IntArray:
    """(m, n, 2) texels of the image for n texels in the halves of squares of m faces."""
    square, half = np.divmod(faces, 2)
    row, column = np.divmod(square, side)
    origin = np.stack([column, row], axis=1)[:, None] * cell
    turned = np.where(half[:, None, None] == 1, cell - 1 - places, places)
    found: IntArray = origin + turned
    return found
