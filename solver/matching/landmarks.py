"""Landmarks: vertices known to correspond, which choose between symmetric solutions."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError
from solver.mesh import TriangleMesh
from solver.registration import RIGHT_ERROR


def landmark_vertices(
    landmarks: tuple[tuple[int, int], ...], source: TriangleMesh, target: TriangleMesh
) -> IntArray:
    """Return the vertices of landmarks on two meshes.

    Parameters
    ----------
    landmarks
        L pairs of the user's own vertex numbers.
    source, target
        The meshes X and Y.

    Returns
    -------
    (L, 2) int64 vertex indices.

    Raises
    ------
    OptionError
        A vertex is not on its mesh, or repair or simplification has merged two of them. The field
        names the pair and the shape.
    """
    ids = np.array(landmarks, dtype=np.int64).reshape(-1, 2)
    found = np.empty_like(ids)
    for side, (name, mesh) in enumerate((("source", source), ("target", target))):
        found[:, side] = mesh.vertices_of(ids[:, side])
        seen: set[int] = set()
        for place, vertex in enumerate(found[:, side].tolist()):
            field = f"landmarks.{place}.{side}"
            if vertex < 0:
                raise OptionError(
                    field,
                    f"vertex {ids[place, side]} is not part of the {name}'s surface, or of that of"
                    " its component that is matched; give one that is",
                )
            if vertex in seen:
                raise OptionError(
                    field,
                    f"vertex {ids[place, side]} was merged with that of an earlier pair, being in"
                    " the same place or simplified away; leave one of the pairs out",
                )
            seen.add(vertex)
    return found


def contradictions(images: FloatArray, partners: FloatArray, size: float) -> tuple[str, ...]:
    """Name the landmarks that a registration contradicts.

    Parameters
    ----------
    images, partners
        (L, 3) positions on the target: where the registration puts the landmarks of the source, and
        those that were given.
    size
        √area, in the same unit.

    Returns
    -------
    A warning for each that is missed by more than the error of a right answer.
    """
    apart = np.linalg.norm(images - partners, axis=1) / size
    return tuple(
        f"landmarks.{place}: registered, its source vertex is {far:.2f} √area away from its target"
        " vertex; correct the pair, unless the registration is wrong"
        for place, far in enumerate(apart.tolist())
        if far > RIGHT_ERROR
    )
