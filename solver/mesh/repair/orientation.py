"""Which side of a surface is out: faces turned alike, and closed surfaces outwards."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh.repair.edges import same_direction
from solver.mesh.repair.soup import TriangleSoup, counted

_NEARLY_CLOSED = 0.05
"""Area of the fans that would close a surface's holes, relative to its own, up to which it has an
inside."""

_HOLLOW = 1e-3
"""Volume inside, relative to the sphere's of the same area, from which its sign is believed."""


def oriented(soup: TriangleSoup) -> TriangleSoup:
    """Turn faces so that neighbours agree, and closed surfaces so that their normals point out.

    A *patch* is what hangs together over edges with two faces. In each, the orientation that most
    of its area has already is kept; but a closed patch, or one with small holes, that is inside
    out then is turned as a whole. One-sided patches stay as they are.
    """
    edges = soup.edges
    pairs, alike = same_direction(soup.faces, edges)
    patch, turned, one_sided = _two_colouring(pairs, alike, len(soup.faces))
    places = soup.places
    areas = 0.5 * np.linalg.norm(_cross(places, soup.faces), axis=1)
    against = np.bincount(patch, weights=areas * turned) > 0.5 * np.bincount(patch, weights=areas)
    turned = (turned ^ against[patch]) & ~one_sided[patch]
    faces = np.where(turned[:, None], soup.faces[:, ::-1], soup.faces)
    border = edges.counts[edges.of_side] != 2
    inside_out = _inside_out(
        places, faces, np.where(turned[:, None], _reversed(border), border), patch
    )
    inside_out &= ~one_sided
    faces = np.where(inside_out[patch][:, None], faces[:, ::-1], faces)
    notes = []
    if turned.any():
        notes.append(f"turned {counted(int(turned.sum()), 'face')} to agree with their neighbours")
    if inside_out.any():
        notes.append("turned the surface: it was inside out")
    if one_sided.any():
        notes.append("the surface has one side only, as a Möbius strip: no face was turned")
    return replace(soup, faces=faces).noting(*notes)


def _two_colouring(
    pairs: IntArray, alike: BoolArray, n_faces: int
) -> tuple[IntArray, BoolArray, BoolArray]:
    """Patch of each face, whether it is turned against the patch's first, and one-sided patches.

    Every face is there twice, as it is and turned; neighbours are linked where they agree. In an
    orientable patch the two copies of a face hang together with different faces.
    """
    i, j = pairs.T
    turned = np.concatenate([np.where(alike, j + n_faces, j), np.where(alike, j, j + n_faces)])
    links = sp.coo_array(
        (np.ones(2 * len(i), dtype=np.bool_), (np.concatenate([i, i + n_faces]), turned)),
        shape=(2 * n_faces, 2 * n_faces),
    )
    label = connected_components(links, directed=False)[1].astype(np.int64)
    here, there = label[:n_faces], label[n_faces:]
    _, patch = np.unique(np.minimum(here, there), return_inverse=True)
    one_sided = np.zeros(int(patch.max()) + 1, dtype=np.bool_)
    one_sided[patch[here == there]] = True
    return patch.reshape(-1).astype(np.int64), here > there, one_sided


def _inside_out(
    places: FloatArray, faces: IntArray, border: BoolArray, patch: IntArray
) -> BoolArray:
    """(patches,) whether a patch encloses a negative volume, its holes closed by fans.

    `border` (F, 3) marks the sides of faces at which the patch ends.
    """
    count = int(patch.max()) + 1
    cross = _cross(places, faces)
    areas = np.bincount(patch, weights=0.5 * np.linalg.norm(cross, axis=1), minlength=count)
    sixfold = np.einsum("ij,ij->i", places[faces[:, 0]], cross)
    volumes = np.bincount(patch, weights=sixfold, minlength=count) / 6.0
    face, side = np.nonzero(border)
    start, end = faces[face, side], faces[face, (side + 1) % 3]
    hole = _loops(start, end, patch[face], len(places))
    size = np.bincount(hole).clip(1)
    centre = np.stack(
        [np.bincount(hole, weights=places[start, axis]) / size for axis in range(3)], axis=1
    )[hole]
    # The fan runs along the border against the face that it closes.
    fan = np.cross(places[end] - centre, places[start] - centre)
    fans = np.bincount(patch[face], weights=0.5 * np.linalg.norm(fan, axis=1), minlength=count)
    volumes += (
        np.bincount(patch[face], weights=np.einsum("ij,ij->i", centre, fan), minlength=count) / 6.0
    )
    sphere = areas**1.5 / (6.0 * np.sqrt(np.pi))
    inside_out: BoolArray = (fans <= _NEARLY_CLOSED * areas) & (volumes < -_HOLLOW * sphere)
    return inside_out


def _loops(start: IntArray, end: IntArray, patch: IntArray, n_vertices: int) -> IntArray:
    """Number of the hole that each border side belongs to; holes of different patches differ."""
    key, number = np.unique(
        np.concatenate([patch * n_vertices + start, patch * n_vertices + end]), return_inverse=True
    )
    ends = number.reshape(2, -1)
    links = sp.coo_array((np.ones(ends.shape[1]), tuple(ends)), shape=(len(key), len(key)))
    found: IntArray = connected_components(links, directed=False)[1][ends[0]].astype(np.int64)
    return found


def _reversed(sides: BoolArray) -> BoolArray:
    """Marks of a face's sides after the face is turned: (c, b, a) has the sides bc, ab, ca."""
    found: BoolArray = sides[:, [1, 0, 2]]
    return found


def _cross(places: FloatArray, faces: IntArray) -> FloatArray:
    a, b, c = (places[faces[:, corner]] for corner in range(3))
    found: FloatArray = np.cross(b - a, c - a)
    return found
