"""From a point cloud to a surface whose vertices are its points.

1. Points without finite coordinates and outliers are left out, points in the same place merged.
2. Noise is removed for what follows: each point is projected onto the plane of its neighbourhood.
   The vertices of the surface stay where the points are.
3. Every point proposes triangles: those of the Delaunay triangulation of its neighbours in its
   tangent plane. Triangles that three corners agree on come first, others fill what is open.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.point_cloud.assembly import assembled, votes_for
from solver.mesh.point_cloud.normals import fitted_planes, with_consistent_signs
from solver.mesh.point_cloud.voronoi import local_triangles
from solver.mesh.repair import (
    TriangleSoup,
    check_coordinates,
    counted,
    groups_of_equal_rows,
)

_FEWEST = 20
"""Points of the smallest cloud."""

_MOST = 250_000
"""Points of the largest cloud: a surface takes 60 µs and 4 kB for each."""

_REACH = 40
"""Neighbours that a point sees. Of uniformly random points they reach 3.6 mean distances √(area /
points) far, and circumcircles up to half of that are seen: one in 20,000 is larger."""

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
"""Displacement, in distances to the nearest point, before points are triangulated: four points of a
regular grid are on a circle, and have to agree on a diagonal."""

_STRAIGHT = 1e-6
"""Extent across a line, in that along it, up to which points lie on the line."""

_AGREED = 0.5
"""Least share of the triangles on which three corners agree: 0.95 for 10,000 random points on a
body, 0.8 with noise of 0.7 mean distances √(area / points), 0.7 for 300 points; 0.45 with noise of
1.5 mean distances, 0.3 to 0.37 for points that fill a volume."""


def surface_of_points(cloud: TriangleSoup) -> TriangleSoup:
    """Make a surface of a point cloud.

    Parameters
    ----------
    cloud
        Points without faces; their normals are used if all have one.

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
    faces, votes = _triangulated(places, given)
    agreed = float((votes == 3).mean()) if len(votes) else 0.0
    if agreed < _AGREED:
        raise MeshError(
            f"the {len(kept)} points are too sparse or too noisy to give a surface: neighbouring"
            f" points agree on {100.0 * agreed:.0f} % of its triangles only; sample the surface"
            " more densely, smooth the points, or upload a mesh"
        )
    into = groups_of_equal_rows((cloud.vertices + 0.0).T)
    into = np.where(np.isfinite(cloud.vertices).all(axis=1), into, np.arange(len(into)))
    merged = replace(cloud, faces=kept[faces], face_ids=None, normals=None).with_vertices_merged(
        into
    )
    notes = [f"a surface of {counted(len(faces), 'triangle')} was made of the points"]
    unreadable = int((~np.isfinite(cloud.vertices).all(axis=1)).sum())
    if unreadable:
        notes.append(f"left out {counted(unreadable, 'point')} without finite coordinates")
    if len(merged.merged):
        notes.append(f"merged {counted(len(merged.merged), 'point')} in the same place as others")
    if alone.any():
        notes.append(f"left out {counted(int(alone.sum()), 'outlier')}, far from all other points")
    unused = len(places) - len(np.unique(faces))
    if unused:
        notes.append(f"left out {counted(unused, 'point')} that no triangle uses")
    return merged.noting(*notes)


def _usable(cloud: TriangleSoup) -> IntArray:
    """Points with finite coordinates, the first of each place."""
    finite = np.flatnonzero(np.isfinite(cloud.vertices).all(axis=1))
    first = groups_of_equal_rows((cloud.vertices[finite] + 0.0).T)
    found: IntArray = finite[first == np.arange(len(finite))]
    return found


def _unit(normals: FloatArray) -> FloatArray | None:
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    if not np.isfinite(lengths).all() or lengths.min(initial=np.inf) < 1e-6:
        return None
    unit: FloatArray = normals / lengths
    return unit


def _outliers(points: FloatArray) -> BoolArray:
    distances, near = KDTree(points).query(points, _NEAR + 1)
    mean = np.asarray(distances)[:, 1:].mean(axis=1)
    alone: BoolArray = mean > _LONELY * np.median(mean[np.asarray(near)[:, 1:]], axis=1)
    # Stray points are near others of their kind, too.
    stray: BoolArray = mean > _SPARSE * np.median(mean)
    return alone | stray if stray.mean() <= _STRAY else alone


def _triangulated(points: FloatArray, given: FloatArray | None) -> tuple[IntArray, IntArray]:
    """(F, 3) faces and (F,) votes, with the normals that are given, or fitted ones."""
    near = _neighbours(points)
    centres, normals = fitted_planes(points, near[:, :_PLANE])
    if given is not None:
        normals = given
    offsets = np.einsum("ij,ij->i", points - centres, normals)
    smooth = points - offsets[:, None] * normals
    spacing = np.linalg.norm(smooth[near[:, 0]] - smooth, axis=1, keepdims=True)
    smooth += _JITTER * spacing * np.random.default_rng(0).standard_normal(smooth.shape)
    near = _neighbours(smooth)
    if given is None:
        normals = fitted_planes(smooth, near[:, :_PLANE])[1]
    triangles, votes = votes_for(local_triangles(smooth, near, normals))
    if given is None:
        normals = with_consistent_signs(smooth, normals, triangles[votes == 3], near)
    return assembled(smooth, normals, triangles, votes)


def _neighbours(points: FloatArray) -> IntArray:
    """(V, k) nearest points of each, the nearest first, without itself."""
    count = min(_REACH, len(points) - 1)
    near = np.asarray(KDTree(points).query(points, count + 1)[1], dtype=np.int64)
    # Points may coincide after smoothing, so that a point is not the first nearest to itself.
    others = near != np.arange(len(points))[:, None]
    others[others.all(axis=1), -1] = False
    found: IntArray = near[others].reshape(len(points), count)
    return found
