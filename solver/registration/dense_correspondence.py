"""Dense correspondence: a map of all vertices in the numbers of the user's files."""

from dataclasses import dataclass

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh


@dataclass(frozen=True, eq=False)
class DenseCorrespondence:
    """A map of all vertices, and its inverse.

    Parameters
    ----------
    source
        (K,) the user's numbers of all vertices of the source's surface, ascending, but of those
        without a partner on a part.
    target
        (K,) the user's number of the vertex nearest to each one's image; several may have the same.
    faces
        (K, 3) the user's numbers of the corners of the target's triangle that the image lies in.
    barycentric
        (K, 3) float64 barycentric coordinates of the image there; each row sums to 1.
    hypothesis
        Hypothesis that agrees best with the map: 0 for the match's best, or one more than a place
        among its alternatives.
    inverse
        The map of all vertices of the target to the source, by the same registration: its `source`
        are vertices of the target, and its own `inverse` is ``None``.
    """

    source: IntArray
    target: IntArray
    faces: IntArray
    barycentric: FloatArray
    hypothesis: int = 0
    inverse: "DenseCorrespondence | None" = None


def in_numbers_of_files(
    source: TriangleMesh,
    target: TriangleMesh,
    images: IntArray,
    faces: IntArray,
    barycentric: FloatArray,
    mapped: BoolArray | None = None,
) -> DenseCorrespondence:
    """Return a map of vertices in the user's numbers, those of merged vertices included.

    Parameters
    ----------
    source, target
        The meshes.
    images, faces, barycentric
        (V,), (V,) and (V, 3) nearest vertices, triangles and coordinates of all source vertices.
    mapped
        (V,) source vertices that have an image, by default all.
    """
    ids, vertices = source.numbering
    if mapped is not None:
        ids, vertices = ids[mapped[vertices]], vertices[mapped[vertices]]
    number = target.vertex_ids
    return DenseCorrespondence(
        ids,
        number[images[vertices]],
        number[target.faces[faces[vertices]]],
        barycentric[vertices],
    )
