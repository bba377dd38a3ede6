"""Textures and texture coordinates of stored shapes."""

from collections.abc import Callable

import numpy as np

from broker.store import Shapes
from solver import registration, transfer
from solver.errors import OptionError
from solver.mesh import TriangleMesh, mapped_surface, textured_surface
from solver.mesh.textures import Paint
from solver.transfer import CORNERS, Attribute
from worker.jobs.failures import ShapeGone, content_of

_Surface = tuple[TriangleMesh, Paint]


def texture_of(shape: str, shapes: Shapes) -> _Surface:
    """Return the surface of a shape as its file has it, and its textures.

    Raises
    ------
    ShapeGone
        The shape was deleted.
    OptionError
        It has no texture.
    """
    missing = "the shape has no texture; `colors` carries those of vertices"
    return _read(shape, shapes, textured_surface, missing)


def own_textures(shape: str, shapes: Shapes) -> _Surface | None:
    """Return the surface of a shape as :func:`texture_of` does, or None if it has no texture.

    Raises
    ------
    ShapeGone
        The shape was deleted.
    """
    return textured_surface(*_file_of(shape, shapes))


def carried_paint(
    shape: str, target: TriangleMesh, back: registration.DenseCorrespondence, shapes: Shapes
) -> Paint:
    """Return the texture coordinates of a shape, carried to the faces of a target.

    Raises
    ------
    ShapeGone
        The shape was deleted.
    OptionError
        It has no texture coordinates.
    """
    missing = "the shape has no texture coordinates; those of OBJ, and of images in GLB, are read"
    return transfer.carried_paint(target, back, *_read(shape, shapes, mapped_surface, missing))


def corner_attributes(target: TriangleMesh, paint: Paint) -> tuple[Attribute, ...]:
    """Return texture coordinates of the corners of triangles, v upwards, and vertices there."""
    textured = np.repeat(paint.texture_of_face >= 0, 3)
    upwards = paint.coordinates.reshape(-1, 2) * [1.0, -1.0] + [0.0, 1.0]
    return (
        Attribute("vertex", target.vertex_ids[target.faces].ravel(), on=CORNERS),
        Attribute("uv", np.where(textured[:, None], upwards, np.nan), ("u", "v"), CORNERS),
        Attribute("texture", np.repeat(paint.texture_of_face, 3), on=CORNERS),
    )


def _read(
    shape: str, shapes: Shapes, reader: Callable[[bytes, str], _Surface | None], missing: str
) -> _Surface:
    found = reader(*_file_of(shape, shapes))
    if found is None:
        raise OptionError("what", missing)
    return found


def _file_of(shape: str, shapes: Shapes) -> tuple[bytes, str]:
    with content_of(shape):
        record, data = shapes.get(shape), shapes.upload(shape)
    if record is None or data is None:
        raise ShapeGone(shape)
    return data, record.file_type
