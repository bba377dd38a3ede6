"""Vertex colours from textures: the mean over the barycentric cell of each vertex.

The barycentric cell of a vertex has the points of its triangles nearer to it than to the other
corners, in barycentric coordinates: a third of each. The texture is sampled at points evenly spaced
over each triangle; where texels are denser than these, in an image that is halved accordingly (a
mipmap). Triangles have their own texture coordinates, so a vertex on a seam gets the colours of
both sides.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.textures.light import tinted
from solver.mesh.textures.material import Material
from solver.mesh.textures.texture import Texture

_FEWEST, _MOST = 2, 8
"""Least and largest number of parts into which an edge is cut, for samples."""

_CHUNK = 1 << 18
"""Samples taken at once."""

_LONGEST = 1e9
"""Length in texels that longer edges count as; no image has as many."""

_FLAT = 1e-9
"""Weight of a triangle without area, in mean areas: it counts where there is no other only."""


@dataclass(frozen=True, eq=False)
class Paint:
    """Colours and textures of triangles.

    Parameters
    ----------
    coordinates
        (F, 3, 2) texture coordinates of the corners, v downwards; not read where there is no
        texture.
    colors
        (F, 3) display values in 0..1 where there is no texture.
    texture_of_face
        (F,) index into `textures`, -1 for none.
    textures
        The textures; empty if only texture coordinates are known, which faces of texture 0 have.
    light
        (F, 3) factors of linear light on textures, in 0..1; ``None`` for 1. Samples are tinted,
        not images: materials may share one.
    material_of_face
        (F,) index into `materials`, -1 for none; ``None`` where they are not known.
    materials
        What faces have besides colours and textures.
    """

    coordinates: FloatArray
    colors: FloatArray
    texture_of_face: IntArray
    textures: tuple[Texture, ...]
    light: FloatArray | None = None
    material_of_face: IntArray | None = None
    materials: tuple[Material, ...] = ()


def painted_colors(vertices: FloatArray, faces: IntArray, paint: Paint) -> FloatArray:
    """Mean colours over the barycentric cells of vertices.

    Parameters
    ----------
    vertices
        (V, 3).
    faces
        (F, 3) vertex indices.
    paint
        Colours and textures of these faces.

    Returns
    -------
    (V, 3) display values in 0..1; 0 at vertices of no face. Areas times colours sum to the
    integral of the texture over the surface, up to the spacing of the points.

    Raises
    ------
    MeshError
        A texture coordinate that is used is not a finite number.
    """
    textured = paint.texture_of_face >= 0
    if not np.isfinite(paint.coordinates[textured]).all():
        raise MeshError("a texture coordinate is not a finite number")
    values = np.repeat(paint.colors[:, None], 3, axis=1).astype(np.float64)
    by_texture = np.argsort(paint.texture_of_face, kind="stable")
    bounds = np.searchsorted(paint.texture_of_face[by_texture], np.arange(len(paint.textures) + 1))
    for number, texture in enumerate(paint.textures):
        mine = by_texture[bounds[number] : bounds[number + 1]]
        for chosen, parts, level in _alike(paint.coordinates, mine, texture):
            light = np.ones(3) if paint.light is None else paint.light[chosen][:, None]
            coordinates = paint.coordinates[chosen]
            values[chosen] = _corner_means(texture, coordinates, parts, level, light)
    corners = faces.reshape(-1)
    shares = np.repeat(_areas(vertices, faces) / 3.0, 3)
    totals = np.bincount(corners, shares, len(vertices))
    sums = np.stack(
        [
            np.bincount(corners, shares * values[:, :, channel].reshape(-1), len(vertices))
            for channel in range(3)
        ],
        axis=1,
    )
    colors: FloatArray = sums / np.where(totals > 0.0, totals, 1.0)[:, None]
    return colors.clip(0.0, 1.0)


def _areas(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """(F,) areas up to a factor, none of which vanishes."""
    used = vertices[faces]
    with np.errstate(all="ignore"):
        scale = float(np.abs(used - used[:1, :1]).max(initial=0.0))
        unit = (used - used[:1, :1]) / scale
        areas = np.linalg.norm(np.cross(unit[:, 1] - unit[:, 0], unit[:, 2] - unit[:, 0]), axis=1)
    areas = np.where(np.isfinite(areas), areas, 0.0)
    mean = float(areas.mean()) if len(areas) else 0.0
    found: FloatArray = areas + (_FLAT * mean or 1.0)
    return found


def _alike(
    coordinates: FloatArray, own: IntArray, texture: Texture
) -> Iterator[tuple[IntArray, int, int]]:
    """Yield faces with the same number of parts and level of the image, in chunks."""
    with np.errstate(over="ignore", invalid="ignore"):
        places = coordinates[own] * np.array(texture.size, dtype=np.float64)
        edges = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).max(axis=1, initial=0)
    edges = np.nan_to_num(edges, nan=_LONGEST, posinf=_LONGEST).clip(0.0, _LONGEST)
    doublings = np.ceil(np.log2(np.maximum(edges, 1.0))).astype(np.int64)
    parts = 2 ** doublings.clip(int(np.log2(_FEWEST)), int(np.log2(_MOST)))
    levels = np.ceil(np.log2(np.maximum(edges / parts, 1.0))).astype(np.int64)
    kinds, kind = np.unique(np.stack([parts, levels], axis=1), axis=0, return_inverse=True)
    kind = kind.reshape(-1)
    for number, (count, level) in enumerate(kinds.tolist()):
        chosen = own[kind == number]
        step = max(_CHUNK // count**2, 1)
        for start in range(0, len(chosen), step):
            yield chosen[start : start + step], count, level


def _corner_means(
    texture: Texture, coordinates: FloatArray, parts: int, level: int, light: FloatArray
) -> FloatArray:
    """(n, 3, 3) mean colour of the third of each triangle that belongs to each corner."""
    points, of_corner = barycentric_pattern(parts)
    places = np.einsum("pc,ncd->npd", points, coordinates)
    found = texture.sample(places.reshape(-1, 2), level).reshape(len(coordinates), len(points), 3)
    means: FloatArray = np.einsum("pc,npk->nck", of_corner, tinted(found, light))
    return means


def barycentric_pattern(parts: int) -> tuple[FloatArray, FloatArray]:
    """Centres of the equal triangles that a triangle is cut into, and their corners.

    Parameters
    ----------
    parts
        Number of parts into which an edge is cut.

    Returns
    -------
    points
        (parts², 3) barycentric coordinates.
    of_corner
        (parts², 3) weights, of sum 1 over the points of each corner.
    """
    i, j = np.meshgrid(np.arange(parts), np.arange(parts), indexing="ij")
    upright = np.stack([i, j], axis=2)[i + j < parts] + 1.0 / 3.0
    hanging = np.stack([i, j], axis=2)[i + j < parts - 1] + 2.0 / 3.0
    two = np.concatenate([upright, hanging]) / parts
    points = np.column_stack([two, 1.0 - two.sum(axis=1)])
    greatest = points >= points.max(axis=1, keepdims=True) - 1e-9
    of_corner = greatest / greatest.sum(axis=1, keepdims=True)
    return points, of_corner / of_corner.sum(axis=0)
