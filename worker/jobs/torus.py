"""A small mesh, connected, coloured and without symmetry.

The warm-up runs its jobs on it, and the validation of a prototype counts on it how many values each
descriptor has at a point.
"""

import numpy as np

from solver.arrays import FloatArray, IntArray


def torus_file() -> bytes:
    """Return a coloured torus with a tube of varying width, as an OFF file."""
    # Of 12 by 8, a match is proven before it branches, and the warm-up leaves a kernel out.
    vertices, faces = _torus(16, 10)
    colors = 0.5 + 0.25 * vertices
    lines = ["COFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(map(str, row)) for row in np.hstack([vertices, colors]).tolist()]
    lines += ["3 " + " ".join(map(str, face)) for face in faces.tolist()]
    return "\n".join(lines).encode()


def _torus(around: int, across: int) -> tuple[FloatArray, IntArray]:
    i, j = np.divmod(np.arange(around * across), across)
    u, v = 2.0 * np.pi * i / around, 2.0 * np.pi * j / across
    tube = 0.3 + 0.1 * np.sin(u) + 0.05 * np.cos(2.0 * u + 1.0) + 0.03 * np.cos(v)
    radius = 1.0 + tube * np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), tube * np.sin(v)], axis=1)
    east = (i + 1) % around * across
    north = (j + 1) % across
    corners = np.stack([i * across + j, east + j, east + north, i * across + north], axis=1)
    return vertices, np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
