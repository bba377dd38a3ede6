"""All straight lines between the vertices of a small polyhedral surface, by trying them out."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray
from solver.mesh import TriangleMesh


def straight_lines(mesh: TriangleMesh) -> FloatArray:
    """(V, V) length of the shortest straight line between vertices; ``inf`` if there is none."""
    search = _Search.of(mesh)
    for number, face in enumerate(mesh.faces):
        for turn in range(3):
            source, i, j = (int(corner) for corner in np.roll(face, turn))
            right = complex(search.lengths[source, i])
            left = search.corner(0.0, right, source, i, j)
            edge = (j, left, i, right)
            search.look(source, edge, left, right, frozenset([number]))
    return search.found


@dataclass(frozen=True, eq=False)
class _Search:
    """Triangles are laid out one after another, none twice, with what can be seen through them."""

    lengths: FloatArray
    beyond: dict[frozenset[int], list[tuple[int, int]]]
    """By the ends of an edge, each of its triangles and the third corner there."""
    found: FloatArray

    @classmethod
    def of(cls, mesh: TriangleMesh) -> "_Search":
        beyond: dict[frozenset[int], list[tuple[int, int]]] = {}
        for number, face in enumerate(mesh.faces.tolist()):
            for corner in face:
                ends = frozenset(face) - {corner}
                beyond.setdefault(ends, []).append((number, corner))
        lengths = np.linalg.norm(mesh.vertices[:, None] - mesh.vertices, axis=2)
        found = np.full_like(lengths, np.inf)
        i, j = mesh.edges.T
        found[i, j] = found[j, i] = lengths[i, j]
        np.fill_diagonal(found, 0.0)
        return cls(lengths, beyond, found)

    def corner(self, p: complex, q: complex, i: int, j: int, k: int) -> complex:
        """Corner k of a triangle whose i is at p and j at q, to the left on the way."""
        base = abs(q - p)
        along = (self.lengths[i, k] ** 2 + base**2 - self.lengths[j, k] ** 2) / (2.0 * base)
        above = np.sqrt(max(self.lengths[i, k] ** 2 - along**2, 0.0))
        return complex(p + (q - p) / base * complex(along, above))

    def look(
        self,
        source: int,
        edge: tuple[int, complex, int, complex],
        left: complex,
        right: complex,
        seen: frozenset[int],
    ) -> None:
        """Look from 0 through an edge, its left end first, in directions from left to right."""
        i, p, j, q = edge
        for number, k in self.beyond[frozenset((i, j))]:
            if number in seen:
                continue
            r = self.corner(p, q, i, j, k)
            from_left, to_right = -np.angle(r / left), -np.angle(right / r)
            if min(from_left, to_right) >= -1e-12:
                self.found[source, k] = min(self.found[source, k], abs(r))
            more = seen | {number}
            if from_left > 1e-12:
                self.look(source, (i, p, k, r), left, r if to_right > 0.0 else right, more)
            if to_right > 1e-12:
                self.look(source, (k, r, j, q), r if from_left > 0.0 else left, right, more)
