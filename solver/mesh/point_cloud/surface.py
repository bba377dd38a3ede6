"""From a point cloud to a surface whose vertices are its points.

1. Points without finite coordinates and outliers are left out, points in the same place merged.
2. Noise is removed for what follows: each point is projected onto the plane of its neighbourhood.
   The vertices of the surface stay where the points are.
3. Normals are those of fitted planes, on the side from which a point is seen, unless given.
4. The surface is what lies between the Delaunay tetrahedra inside and those outside.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.point_cloud.normals import fitted_planes, outward_normals
from solver.mesh.point_cloud.tetrahedra import NO_SURFACE, boundary_of_inside
from solver.mesh.repair import (
    TriangleSoup,
    check_coordinates,
    counted,
    groups_of_equal_rows,
)

_FEWEST = 20
"""Points of the smallest cloud."""

_MOST = 250_000
"""Points of the largest cloud: a surface takes 70 to 100 µs and 6 kB for each."""

_PLANE = 20
"""Neighbours that planes are fitted to."""

_NEAR = 8
"""Neighbours whose mean distance says how dense the points are."""

_LONELY = 4.0
"""Mean distance to the near neighbours, in those of the neighbours themselves (the local outlier
factor: Breunig, Kriegel, Ng and Sander, SIGMOD 2000), beyond which a point is an outlier. None of
100,000 uniformly random points on a surface is."""

_SPARSE = 8.0
"""The same distance, in its median over the cloud, beyond which points lie in no surface. Of people
and animals it is 4.7 at most, of stray points in the space round them 10 and more."""

_STRAY = 0.05
"""Most of the points that are left out for that: more may be a surface that is sampled unevenly."""

_JITTER = 0.01
"""Displacement, in distances to the nearest point, before points are triangulated: those in a plane
have no tetrahedra."""

_STRAIGHT = 1e-6
"""Extent across a line, in that along it, up to which points lie on the line."""

_THICKEST = 0.5
"""Median over the points of how thick neighbourhoods are, over how wide, as variances: 0.003 for
3,000 random points on a sphere, 0.11 with noise of 0.7 mean distances √(area / points), 0.35 with
1.5; 0.4 for 300 points on a body; 0.56 to 0.64 for points that fill a volume."""


def surface_of_points(cloud: TriangleSoup) -> TriangleSoup:
    """Make a surface of a point cloud.

    Parameters
    ----------
    cloud
        Points without faces; their normals are used, if they have any.

    Returns
    -------
    TriangleSoup
        The same points, with faces, consistently wound. Points that are left out have no face.

    Raises
    ------
    MeshError
        There are too few points or too many, or they do not lie on a surface, as far as their
        density and noise can tell.
    """
    kept = _usable(cloud)
    places = cloud.vertices[kept]
    if len(kept) < _FEWEST:
        raise MeshError(
            f"a surface needs {_FEWEST} points or more in different places; there are {len(kept)}"
        )
    if len(kept) > _MOST:
        raise MeshError(
            f"a surface is made of {_MOST} points at most; there are {len(kept)}: thin them out,"
            " or upload a mesh"
        )
    check_coordinates(places, np.arange(len(places)))
    places = (places - places.mean(axis=0)) / np.ptp(places, axis=0).max()
    alone = _outliers(places)
    kept, places = kept[~alone], places[~alone]
    along, across = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)[:2]
    if across <= _STRAIGHT * along:
        raise MeshError("all points lie on a line; check which columns are x, y and z")
    given = None if cloud.normals is None else _unit(cloud.normals[kept])
    near = _neighbours(places)
    centres, normals, thickness = fitted_planes(places, near)
    if np.median(thickness) > _THICKEST:
        raise MeshError(
            f"the {len(kept)} points are too sparse or too noisy to give a surface: of"
            f" {near.shape[1]} neighbours, the variance across their plane is"
            f" {100.0 * np.median(thickness):.0f} % of that along it; sample the surface more"
            " densely, smooth the points, or upload a mesh"
        )
    faces = _triangulated(places, centres, normals, given)
    if not len(faces):
        raise MeshError(NO_SURFACE)
    used, off = _on_and_off(faces, len(places))
    into = groups_of_equal_rows((cloud.vertices + 0.0).T)
    unreadable = ~np.isfinite(cloud.vertices).all(axis=1)
    into = np.where(unreadable, np.arange(len(into)), into)
    repeated = int((into != np.arange(len(into))).sum())
    into[kept[off]] = kept[used[KDTree(places[used]).query(places[off])[1]]]
    merged = replace(cloud, faces=kept[faces], face_ids=None, normals=None)
    counts = (
        (int(unreadable.sum()), "left out {} without finite coordinates", "point"),
        (repeated, "merged {} in the same place as others", "point"),
        (int(alone.sum()), "left out {}, far from all other points", "outlier"),
        (len(off), "merged {} off the surface with the nearest on it", "point"),
    )
    return merged.with_vertices_merged(into[into]).noting(
        f"a surface of {counted(len(faces), 'triangle')} was made of the points",
        *(text.format(counted(count, name)) for count, text, name in counts if count),
    )


def _on_and_off(faces: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Points that faces use, and those that none does."""
    used = np.zeros(count, dtype=np.bool_)
    used[faces] = True
    return np.flatnonzero(used), np.flatnonzero(~used)


def _usable(cloud: TriangleSoup) -> IntArray:
    """Points with finite coordinates, the first of each place."""
    finite = np.flatnonzero(np.isfinite(cloud.vertices).all(axis=1))
    first = groups_of_equal_rows((cloud.vertices[finite] + 0.0).T)
    found: IntArray = finite[first == np.arange(len(finite))]
    return found


def _unit(normals: FloatArray) -> FloatArray | None:
    """(V, 3) unit normals, 0 where there is none; ``None`` if there are none at all."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    known = np.isfinite(lengths) & (lengths > 0.0)
    if not known.any():
        return None
    unit: FloatArray = np.where(known, normals, 0.0) / np.where(known, lengths, 1.0)
    return unit


def _outliers(points: FloatArray) -> BoolArray:
    mean, near = _distances(points, _NEAR)
    alone: BoolArray = mean > _LONELY * np.median(mean[near], axis=1)
    # Stray points are near others of their kind, too.
    stray: BoolArray = mean > _SPARSE * np.median(mean)
    return alone | stray if stray.mean() <= _STRAY else alone


def _triangulated(
    points: FloatArray, centres: FloatArray, normals: FloatArray, given: FloatArray | None
) -> IntArray:
    """(F, 3) faces of points near fitted planes, with the normals that are given, or of planes."""
    if given is not None:
        normals = np.where(given.any(axis=1, keepdims=True), given, normals)
    offsets = np.einsum("ij,ij->i", points - centres, normals)
    smooth = points - offsets[:, None] * normals
    nearest, _ = _distances(smooth, 1)
    random = np.random.default_rng(0).standard_normal(smooth.shape)
    smooth += _JITTER * nearest[:, None] * random
    density, _ = _distances(smooth, _NEAR)
    if given is None:
        near = _neighbours(smooth)
        _, planes, _ = fitted_planes(smooth, near)
        given = outward_normals(smooth, planes, near, float(np.median(density)))
    return boundary_of_inside(smooth, given, density)


def _distances(points: FloatArray, count: int) -> tuple[FloatArray, IntArray]:
    """(V,) mean distances of points to the nearest ones, and (V, k) these."""
    distances, near = KDTree(points).query(points, count + 1)
    return np.asarray(distances)[:, 1:].mean(axis=1), np.asarray(near)[:, 1:]


def _neighbours(points: FloatArray) -> IntArray:
    """(V, k) nearest points of each, the nearest first, without itself."""
    count = min(_PLANE, len(points) - 1)
    near = np.asarray(KDTree(points).query(points, count + 1)[1], dtype=np.int64)
    # Points may coincide after smoothing, so that a point is not the first nearest to itself.
    others = near != np.arange(len(points))[:, None]
    others[others.all(axis=1), -1] = False
    found: IntArray = near[others].reshape(len(points), count)
    return found
