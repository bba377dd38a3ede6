"""Points of a surface, between its vertices: nearest to positions in space, and their images."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from isomatch._models import VertexMap
from isomatch._results import Geometry

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_EDGES: Final = ((0, 1), (1, 2), (2, 0))


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points in the triangles of a surface.

    Attributes
    ----------
    faces
        Corners of the triangle of each point, by the vertex numbers of the file, (n, 3) int64.
    weights
        Barycentric coordinates of each point in its triangle, (n, 3) float64.
    """

    faces: Indices
    weights: Floats

    def positions(self, geometry: Geometry) -> Floats:
        """Return the positions of the points in space, (n, 3) float64."""
        found: Floats = np.einsum("nc,ncd->nd", self.weights, geometry.positions(self.faces))
        return found

    def at(self, rows: npt.NDArray[np.int64] | npt.NDArray[np.bool_]) -> "SurfacePoints":
        """Return the points of some rows."""
        return SurfacePoints(self.faces[rows], self.weights[rows])

    def among(self, vertices: Indices) -> npt.NDArray[np.bool_]:
        """Return whether all corners of the triangle of each point are among vertices, (n,)."""
        found: npt.NDArray[np.bool_] = np.all(np.isin(self.faces, vertices), axis=1)
        return found


def nearest_points(geometry: Geometry, positions: Floats) -> SurfacePoints:
    """Find the points of a surface nearest to positions in space.

    Parameters
    ----------
    geometry
        The surface, with F triangles.
    positions
        (n, 3) finite. Each takes O(F).
    """
    corners = geometry.vertices[geometry.faces]
    middles = corners.mean(axis=1)
    radii = np.sqrt(((corners - middles[:, None]) ** 2).sum(axis=2).max(axis=1))
    used = np.unique(geometry.faces)
    rows, weights = [], []
    for position in positions:
        bound = _distances(geometry.vertices[used], position).min()
        # The tolerance keeps the triangles of the nearest vertex despite rounding.
        near = _distances(middles, position) - radii <= bound * (1.0 + 1e-9) + 1e-12 * radii
        place, found = _nearest_in_triangles(corners[near], position)
        rows.append(np.flatnonzero(near)[place])
        weights.append(found)
    faces = geometry.faces[np.array(rows, dtype=np.int64)].reshape(-1, 3)
    return SurfacePoints(geometry.vertex_ids[faces], np.array(weights).reshape(-1, 3))


def images(points: SurfacePoints, along: VertexMap, geometry: Geometry) -> SurfacePoints:
    """Map points of one surface to the other.

    The image of a vertex is that of the map. The image of another point is the point of the other
    surface nearest to the barycentric mean of the images of its triangle's corners, near these:
    the search begins at the image of the nearest corner, so that it stays on its limb.

    Parameters
    ----------
    points
        Of the surface that is mapped.
    along
        The map of its vertices.
    geometry
        The other surface.

    Raises
    ------
    ValueError
        A corner is no vertex of the mapped surface, or the map has no images between vertices.
    """
    if len(along.faces) < len(along.vertices):
        raise ValueError("the result has no images between vertices; match again")
    rows = np.searchsorted(along.vertices, points.faces).clip(max=len(along.vertices) - 1)
    unknown = points.faces[along.vertices[rows] != points.faces]
    if unknown.size:
        raise ValueError(f"vertex {unknown[0]} is not part of the matched surface")
    triangles = geometry.rows(along.faces[rows])
    corners = np.einsum("ncb,ncbd->ncd", along.weights[rows], geometry.vertices[triangles])
    means = np.einsum("nc,ncd->nd", points.weights, corners)
    nearest = points.weights.argmax(axis=1)
    rings = _Rings.of(geometry)
    faces, weights = [], []
    for place, mean in enumerate(means):
        corner = nearest[place]
        main = along.weights[rows[place, corner]].argmax()
        face, found = _descend(geometry, rings, mean, int(triangles[place, corner, main]))
        faces.append(geometry.vertex_ids[geometry.faces[face]])
        weights.append(found)
    return SurfacePoints(np.array(faces).reshape(-1, 3), np.array(weights).reshape(-1, 3))


@dataclass(frozen=True, eq=False)
class _Rings:
    """Rows of the faces around each vertex: those of v are `faces[first[v]:first[v + 1]]`."""

    first: Indices
    faces: Indices

    @classmethod
    def of(cls, geometry: Geometry) -> "_Rings":
        """Sort the corners by vertex, in O(F log F)."""
        corners = geometry.faces.ravel()
        counts = np.bincount(corners, minlength=len(geometry.vertices))
        first = np.concatenate([[0], np.cumsum(counts)])
        return cls(first, np.argsort(corners, kind="stable") // 3)

    def around(self, vertex: int) -> Indices:
        """Return the rows of the faces around a vertex."""
        return self.faces[self.first[vertex] : self.first[vertex + 1]]


def _descend(geometry: Geometry, rings: _Rings, position: Floats, start: int) -> tuple[int, Floats]:
    """Row and coordinates of the triangle nearest to a position, descending from a vertex to it."""
    vertex = start
    while True:
        ring = rings.around(vertex)
        around = np.unique(geometry.faces[ring])
        distances = _distances(geometry.vertices[around], position)
        if distances.min() >= _distances(geometry.vertices[[vertex]], position)[0]:
            place, weights = _nearest_in_triangles(
                geometry.vertices[geometry.faces[ring]], position
            )
            return int(ring[place]), weights
        vertex = int(around[distances.argmin()])


def _nearest_in_triangles(triangles: Floats, position: Floats) -> tuple[int, Floats]:
    """Number of the nearest of (m, 3, 3) triangles, and coordinates of its point, (3,)."""
    found = np.zeros((len(triangles), 4, 3))
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    offset = position - triangles[:, 0]
    uu, uv, vv = _dots(u, u), _dots(u, v), _dots(v, v)
    determinant = np.maximum(uu * vv - uv * uv, np.finfo(float).tiny)
    found[:, 3, 1] = (vv * _dots(u, offset) - uv * _dots(v, offset)) / determinant
    found[:, 3, 2] = (uu * _dots(v, offset) - uv * _dots(u, offset)) / determinant
    found[:, 3, 0] = 1.0 - found[:, 3, 1] - found[:, 3, 2]
    for place, (first, second) in enumerate(_EDGES):
        edge = triangles[:, second] - triangles[:, first]
        length = np.maximum(_dots(edge, edge), np.finfo(float).tiny)
        along = (_dots(position - triangles[:, first], edge) / length).clip(0.0, 1.0)
        found[:, place, first], found[:, place, second] = 1.0 - along, along
    apart = np.einsum("mkc,mcd->mkd", found, triangles) - position
    squares = (apart**2).sum(axis=2)
    # The foot of the perpendicular counts only within its triangle.
    squares[(found[:, 3] < 0.0).any(axis=1), 3] = np.inf
    triangle, place = np.unravel_index(squares.argmin(), squares.shape)
    return int(triangle), found[triangle, place]


def _dots(a: Floats, b: Floats) -> Floats:
    found: Floats = (a * b).sum(axis=1)
    return found


def _distances(points: Floats, position: Floats) -> Floats:
    found: Floats = np.sqrt(((points - position) ** 2).sum(axis=1))
    return found
