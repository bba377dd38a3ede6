"""Winding: made consistent over the surface, and outward where it is closed."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh.edges import components_of, same_direction
from solver.mesh.normals import face_normals, triangle_areas
from solver.mesh.repair.soup import TriangleSoup, counted

_NEARLY_CLOSED = 0.3
"""Area of the fans that would close a patch's holes, relative to its own, up to which it counts as
closed: the larger halves of a body cut in two, but no sheet, whose fans are about as large as it is
unless it is rolled up."""

_SOLID = 1e-3
"""Enclosed volume relative to that of the sphere of equal area, from which its sign is trusted."""


def with_consistent_winding(soup: TriangleSoup) -> TriangleSoup:
    """Flip faces so that neighbours agree, and closed surfaces so that normals point outwards.

    A *patch* is connected over edges of two faces. Each gets the winding that most of its area
    already has; if it is closed, or has small holes, and is inside out then, it is flipped as a
    whole. That goes for each patch alone: the inner wall of a shell, whose normals pointed into its
    hollow, is flipped too. Non-orientable patches stay as they are.
    """
    edges = soup.edges
    pairs, same = same_direction(soup.faces, edges)
    patch, flipped, one_sided = _two_colouring(pairs, same, len(soup.faces))
    positions = soup.unit_positions
    areas = triangle_areas(positions, soup.faces)
    against = np.bincount(patch, weights=areas * flipped) > 0.5 * np.bincount(patch, weights=areas)
    flipped = (flipped ^ against[patch]) & ~one_sided[patch]
    faces = np.where(flipped[:, None], soup.faces[:, ::-1], soup.faces)
    boundary = edges.counts[edges.of_side] != 2
    inside_out = _inside_out(
        positions, faces, np.where(flipped[:, None], _reversed(boundary), boundary), patch
    )
    inside_out &= ~one_sided
    if flipped.any() or inside_out.any():
        faces = np.where(inside_out[patch][:, None], faces[:, ::-1], faces)
        soup = replace(soup, faces=faces)
    notes = []
    if flipped.any():
        notes.append(
            f"inconsistent winding: flipped {counted(int(flipped.sum()), 'face')} to agree with"
            " neighbouring faces"
        )
    if inside_out.all():
        notes.append("flipped all faces of the surface: it was inside out")
    elif inside_out.any():
        some, pieces = int(inside_out.sum()), len(inside_out)
        notes.append(f"flipped all faces of {some} of {pieces} pieces, which were inside out")
    if one_sided.any():
        notes.append("the surface is not orientable, like a Möbius strip: no face was flipped")
    # The winding of a surface made of points is none of the user's.
    return soup if soup.is_cloud else soup.noting(*notes)


def _two_colouring(
    pairs: IntArray, same: BoolArray, n_faces: int
) -> tuple[IntArray, BoolArray, BoolArray]:
    """Patch of each face, whether its winding is opposite to the patch's first face, and one-sided
    patches.

    Every face is there twice, as it is and flipped; copies of neighbours are linked where they
    agree. In an orientable patch the two copies of a face are not connected.
    """
    i, j = pairs.T
    agreeing = np.concatenate([np.where(same, j + n_faces, j), np.where(same, j, j + n_faces)])
    links = sp.coo_array(
        (np.ones(2 * len(i), dtype=np.bool_), (np.concatenate([i, i + n_faces]), agreeing)),
        shape=(2 * n_faces, 2 * n_faces),
    )
    label = connected_components(links, directed=False)[1].astype(np.int64)
    here, there = label[:n_faces], label[n_faces:]
    _, patch = np.unique(np.minimum(here, there), return_inverse=True)
    one_sided = np.zeros(int(patch.max()) + 1, dtype=np.bool_)
    one_sided[patch[here == there]] = True
    return patch.reshape(-1).astype(np.int64), here > there, one_sided


def _inside_out(
    positions: FloatArray, faces: IntArray, boundary: BoolArray, patch: IntArray
) -> BoolArray:
    """(patches,) whether each encloses a negative volume, its holes closed by fans.

    `boundary` (F, 3) marks the sides of faces at which the patch ends.
    """
    count = int(patch.max()) + 1
    cross = face_normals(positions, faces)
    areas = np.bincount(patch, weights=0.5 * np.linalg.norm(cross, axis=1), minlength=count)
    sixfold = np.einsum("ij,ij->i", positions[faces[:, 0]], cross)
    volumes = np.bincount(patch, weights=sixfold, minlength=count) / 6.0
    face, side = np.nonzero(boundary)
    start, end = faces[face, side], faces[face, (side + 1) % 3]
    hole = _loops(start, end, patch[face], len(positions))
    size = np.bincount(hole).clip(1)
    centre = np.stack(
        [np.bincount(hole, weights=positions[start, axis]) / size for axis in range(3)], axis=1
    )[hole]
    # The fan runs along the boundary against the face that it closes.
    fan = np.cross(positions[end] - centre, positions[start] - centre)
    fans = np.bincount(patch[face], weights=0.5 * np.linalg.norm(fan, axis=1), minlength=count)
    volumes += (
        np.bincount(patch[face], weights=np.einsum("ij,ij->i", centre, fan), minlength=count) / 6.0
    )
    sphere = areas**1.5 / (6.0 * np.sqrt(np.pi))
    inside_out: BoolArray = (fans <= _NEARLY_CLOSED * areas) & (volumes < -_SOLID * sphere)
    return inside_out


def _loops(start: IntArray, end: IntArray, patch: IntArray, n_vertices: int) -> IntArray:
    """Number of the hole that each boundary side belongs to; holes of different patches differ."""
    key, number = np.unique(
        np.concatenate([patch * n_vertices + start, patch * n_vertices + end]), return_inverse=True
    )
    ends = number.reshape(2, -1)
    found: IntArray = components_of(ends.T, len(key))[ends[0]]
    return found


def _reversed(sides: BoolArray) -> BoolArray:
    """(F, 3) marks of sides after faces are flipped: (c, b, a) has the sides bc, ab, ca."""
    found: BoolArray = sides[:, [1, 0, 2]]
    return found
