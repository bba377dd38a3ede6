"""Geometry for drawing in a browser: the packed form of meshes, and points of prototypes.

A packed mesh is little-endian, so that a browser reads its arrays in place:

====================  ===========================================================================
8 bytes               ``isogeom1``
3 uint32              V vertices, F triangles, 1 with colours or 0 without
uint32                1 for a point cloud, whose triangles were made of its points, or 0
3 float64             the origin, in the file's unit of length
float64               the scale, likewise
3 V float32           positions relative to the origin, in units of the scale, from -1 to 1
3 F uint32            triangles, as indices of positions
V uint32              0-based index of each vertex in the user's file
3 V uint8, or none    red, green, blue
====================  ===========================================================================
"""

import gzip
import struct
from typing import Final

import numpy as np

from broker.contracts import PrototypeGeometry, PrototypeSurface
from solver.arrays import FloatArray
from solver.mesh import TriangleMesh
from solver.prototype import ExampleSurface, Prototype

MAGIC: Final = b"isogeom1"
_HEADER: Final = "<8s4I4d"
_LEVEL: Final = 4
"""Compression level of gzip; higher ones gain little on coordinates."""

_DECIMALS: Final = 6
"""Of positions in JSON: a millionth of half the surface's extent is below a pixel."""


def packed_geometry(mesh: TriangleMesh) -> bytes:
    """Return the packed form of a mesh, in gzip.

    Positions are relative to the middle and the size of the shape, so that float32 is exact enough
    for shapes of any size and at any distance from the origin of their coordinates.
    """
    origin, scale = _box(mesh.vertices)
    colored = mesh.colors is not None
    counts = mesh.n_vertices, mesh.n_faces, colored, mesh.is_cloud
    header = struct.pack(_HEADER, MAGIC, *counts, *origin, scale)
    parts = [
        header,
        ((mesh.vertices - origin) / scale).astype("<f4").tobytes(),
        mesh.faces.astype("<u4").tobytes(),
        mesh.vertex_ids.astype("<u4").tobytes(),
    ]
    if mesh.colors is not None:
        parts.append(np.rint(255.0 * mesh.colors.clip(0.0, 1.0)).astype(np.uint8).tobytes())
    return _compressed(b"".join(parts))


def packed_prototype(prototype: Prototype) -> bytes:
    """Return the points of a prototype and its first surface, `PrototypeGeometry` in gzip."""
    geometry = PrototypeGeometry(
        vertices=tuple(prototype.vertices.tolist()),
        surface=_surface(prototype.surfaces[0]) if prototype.surfaces else None,
    )
    return _compressed(geometry.model_dump_json().encode())


def _surface(surface: ExampleSurface) -> PrototypeSurface:
    origin, scale = _box(surface.vertices)
    positions = ((surface.vertices - origin) / scale).round(_DECIMALS)
    return PrototypeSurface(
        positions=tuple(map(tuple, positions.tolist())),
        faces=tuple(map(tuple, surface.faces.tolist())),
        points=tuple(surface.points.tolist()),
    )


def _box(vertices: FloatArray) -> tuple[FloatArray, float]:
    """Middle of the bounding box, and half its largest extent."""
    lowest, highest = vertices.min(axis=0), vertices.max(axis=0)
    middle: FloatArray = 0.5 * lowest + 0.5 * highest
    return middle, float((0.5 * highest - 0.5 * lowest).max())


def _compressed(data: bytes) -> bytes:
    # Without a time stamp, so that the same geometry is the same bytes.
    return gzip.compress(data, compresslevel=_LEVEL, mtime=0)
