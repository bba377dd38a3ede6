"""Meshes for those who look at them: positions and triangles that need no reader of mesh files.

Little end first, so that a browser reads the arrays where they lie:

====================  ===========================================================================
8 bytes               ``isogeom1``
3 uint32              V vertices, F triangles, 1 if there are colours and 0 if not
4 bytes               zero
3 float64             the origin, in the file's unit of length
float64               the scale, likewise
3 V float32           positions: from the origin, in units of the scale; all between -1 and 1
3 F uint32            triangles: numbers of positions
V uint32              the user's own number of each vertex, its 0-based index in the file
3 V uint8, or none    red, green, blue
====================  ===========================================================================
"""

import gzip
import struct
from typing import Final

import numpy as np

from solver.mesh import TriangleMesh

MAGIC: Final = b"isogeom1"
_HEADER: Final = "<8s3I4x4d"
_LEVEL: Final = 4
"""Of compression: higher ones gain little on coordinates."""


def packed_geometry(mesh: TriangleMesh) -> bytes:
    """Return the geometry of a mesh, in gzip.

    Positions are relative to the middle and the size of the shape, so that shapes of any size, and
    far from the origin of their coordinates, lose nothing in float32 that could be seen.
    """
    lowest, highest = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    origin, scale = 0.5 * lowest + 0.5 * highest, float((0.5 * highest - 0.5 * lowest).max())
    colored = mesh.colors is not None
    header = struct.pack(_HEADER, MAGIC, mesh.n_vertices, mesh.n_faces, colored, *origin, scale)
    parts = [
        header,
        ((mesh.vertices - origin) / scale).astype("<f4").tobytes(),
        mesh.faces.astype("<u4").tobytes(),
        mesh.vertex_ids.astype("<u4").tobytes(),
    ]
    if mesh.colors is not None:
        parts.append(np.rint(255.0 * mesh.colors.clip(0.0, 1.0)).astype(np.uint8).tobytes())
    # Without a time in it, the same mesh is the same bytes.
    return gzip.compress(b"".join(parts), compresslevel=_LEVEL, mtime=0)
