"""Small meshes whose structure is known, as the files a user would upload."""

import numpy as np
import trimesh

from solver.arrays import FloatArray, IntArray


def blob(subdivisions: int = 3, seed: int = 0) -> tuple[FloatArray, IntArray]:
    """A smooth closed surface without symmetry: an ellipsoid with bumps.

    `seed` turns it and moves it, which is an isometry.
    """
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions)
    points = np.asarray(sphere.vertices, dtype=np.float64)
    bumps = sum(
        height * np.exp(-4.0 * np.sum((points - np.array(centre)) ** 2, axis=1))
        for height, centre in (
            (0.8, (1, 0, 0)),
            (0.5, (0, 1, 0)),
            (0.3, (0, 0, 1)),
            (0.4, (-0.6, -0.8, 0)),
        )
    )
    shape = points * np.array([1.0, 1.4, 2.0]) * (1.0 + bumps)[:, None]
    rotation, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    if seed and np.linalg.det(rotation) > 0:
        shape = shape @ rotation.T + seed
    return shape, np.asarray(sphere.faces, dtype=np.int64)


def off(vertices: FloatArray, faces: IntArray) -> bytes:
    """An OFF file."""
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(f"{x:.9g}" for x in vertex) for vertex in vertices]
    lines += ["3 " + " ".join(map(str, face)) for face in faces]
    return ("\n".join(lines) + "\n").encode()


def blob_file(subdivisions: int = 3, seed: int = 0) -> bytes:
    """A blob as an OFF file."""
    return off(*blob(subdivisions, seed))


def two_blobs_file() -> bytes:
    """Two components, the first of them larger."""
    vertices, faces = blob(2)
    return off(
        np.concatenate([vertices, 0.3 * vertices + 10.0]),
        np.concatenate([faces, faces + len(vertices)]),
    )
