"""Ways in which a mesh file can be damaged, each with what should become of it.

A damage takes a closed surface without symmetry and returns what a careless program would have
written, and where the vertices of the surface are in that. Those of `HARMLESS` leave the surface
as it is, and must not be noticed in any answer; those of `DISTORTING` change it, and must be told
of; `HOPELESS` are to be refused, with a reason.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh


@dataclass(frozen=True, eq=False)
class Damaged:
    """A damaged mesh.

    Attributes
    ----------
    vertices
        (V', 3).
    faces
        Polygons.
    where
        (V,) the number in the file of each vertex of the undamaged mesh.
    scale
        Its lengths, in those of the undamaged mesh.
    """

    vertices: FloatArray
    faces: Sequence[Sequence[int]]
    where: IntArray
    scale: float = 1.0


Damage = Callable[[TriangleMesh], Damaged]


def _damaged(
    mesh: TriangleMesh,
    vertices: FloatArray | None = None,
    faces: IntArray | Sequence[Sequence[int]] | None = None,
    scale: float = 1.0,
) -> Damaged:
    points = mesh.vertices if vertices is None else np.asarray(vertices, dtype=np.float64)
    polygons = mesh.faces if faces is None else faces
    listed = polygons.tolist() if isinstance(polygons, np.ndarray) else polygons
    return Damaged(points, listed, np.arange(mesh.n_vertices), scale)


def _random() -> np.random.Generator:
    return np.random.default_rng(20100707)


def _with_points(mesh: TriangleMesh, *points: npt.ArrayLike) -> FloatArray:
    return np.concatenate([mesh.vertices, *(np.reshape(point, (-1, 3)) for point in points)])


def _hinge(mesh: TriangleMesh, number: int = 100) -> tuple[int, int, int, int, int, int]:
    """Faces f, g at an edge, and corners: f is (i, j, a) and g is (j, i, b), up to rotation."""
    f = number
    i, j, a = (int(corner) for corner in mesh.faces[f])
    beside = ((mesh.faces == i) | (mesh.faces == j)).sum(axis=1) == 2
    g = int(next(face for face in np.flatnonzero(beside) if face != f))
    b = int(mesh.faces[g].sum() - i - j)
    return f, g, i, j, a, b


# --- numbering ------------------------------------------------------------------------------------


def vertices_shuffled(mesh: TriangleMesh) -> Damaged:
    where = _random().permutation(mesh.n_vertices)
    vertices = np.empty_like(mesh.vertices)
    vertices[where] = mesh.vertices
    return Damaged(vertices, where[mesh.faces].tolist(), where)


def faces_shuffled(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, faces=_random().permutation(mesh.faces))


def corners_rotated(mesh: TriangleMesh) -> Damaged:
    shift = _random().integers(0, 3, mesh.n_faces)[:, None]
    return _damaged(mesh, faces=np.take_along_axis(mesh.faces, (np.arange(3) + shift) % 3, axis=1))


def unused_vertices_between(mesh: TriangleMesh) -> Damaged:
    where = 3 * np.arange(mesh.n_vertices) + 2
    vertices = np.full((3 * mesh.n_vertices, 3), 0.123)
    vertices[where] = mesh.vertices
    return Damaged(vertices, where[mesh.faces].tolist(), where)


def unused_vertices_far_away(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, _with_points(mesh, [1e300, -1e300, 0.0], [1e9, 0.0, 0.0]))


def unused_vertices_without_place(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, _with_points(mesh, [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0]))


# --- repeated faces -------------------------------------------------------------------------------


def faces_twice(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, faces=np.concatenate([mesh.faces, mesh.faces[::3]]))


def faces_twice_and_turned(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, faces=np.concatenate([mesh.faces, mesh.faces[::2, [1, 0, 2]]]))


def all_twice(mesh: TriangleMesh) -> Damaged:
    """The whole surface again, on vertices of its own."""
    return _damaged(
        mesh,
        np.concatenate([mesh.vertices, mesh.vertices]),
        np.concatenate([mesh.faces, mesh.faces + mesh.n_vertices]),
    )


def all_twice_and_turned(mesh: TriangleMesh) -> Damaged:
    """The back of the surface as a surface of its own, as programs write that cull back faces."""
    return _damaged(
        mesh,
        np.concatenate([mesh.vertices, mesh.vertices]),
        np.concatenate([mesh.faces, mesh.faces[:, ::-1] + mesh.n_vertices]),
    )


def a_patch_twice(mesh: TriangleMesh) -> Damaged:
    patch = mesh.faces[mesh.vertices[mesh.faces, 2].min(axis=1) > 0.2]
    return _damaged(
        mesh,
        np.concatenate([mesh.vertices, mesh.vertices]),
        np.concatenate([mesh.faces, patch + mesh.n_vertices]),
    )


# --- seams ----------------------------------------------------------------------------------------


def _cut(mesh: TriangleMesh, side: IntArray) -> Damaged:
    """Give the faces of each side vertices of their own."""
    key = mesh.faces + mesh.n_vertices * side[:, None]
    used, faces = np.unique(key, return_inverse=True)
    where = np.full(mesh.n_vertices, -1)
    where[(used % mesh.n_vertices)[::-1]] = np.arange(len(used))[::-1]
    return Damaged(mesh.vertices[used % mesh.n_vertices], faces.reshape(-1, 3).tolist(), where)


def _centroids(mesh: TriangleMesh) -> FloatArray:
    found: FloatArray = mesh.vertices[mesh.faces].mean(axis=1)
    return found


def a_seam(mesh: TriangleMesh) -> Damaged:
    return _cut(mesh, (_centroids(mesh)[:, 0] > 0.1).astype(np.int64))


def crossing_seams(mesh: TriangleMesh) -> Damaged:
    return _cut(mesh, (_centroids(mesh) > 0.1) @ np.array([1, 2, 4]))


def an_open_seam(mesh: TriangleMesh) -> Damaged:
    """A cut that ends within the surface."""
    x, y, z = _centroids(mesh).T
    return _cut(mesh, ((x > 0.1) & (y > 0.1) & (z > 0.1)).astype(np.int64))


def loose_faces(mesh: TriangleMesh) -> Damaged:
    return _cut(mesh, np.arange(mesh.n_faces))


def loose_faces_turned_at_random(mesh: TriangleMesh) -> Damaged:
    damaged = loose_faces(mesh)
    turned = _random().random(mesh.n_faces) < 0.4
    faces = [face[::-1] if turn else face for face, turn in zip(damaged.faces, turned, strict=True)]
    return Damaged(damaged.vertices, faces, damaged.where)


def _jittered(damaged: Damaged, size: float) -> Damaged:
    noise = size * _random().standard_normal(damaged.vertices.shape)
    return Damaged(damaged.vertices + noise, damaged.faces, damaged.where)


def a_seam_that_gapes(mesh: TriangleMesh) -> Damaged:
    return _jittered(a_seam(mesh), 1e-6)


def loose_faces_that_gape(mesh: TriangleMesh) -> Damaged:
    return _jittered(loose_faces(mesh), 1e-6)


def a_seam_in_six_digits(mesh: TriangleMesh) -> Damaged:
    """One side written with six digits, the other with all."""
    damaged = a_seam(mesh)
    vertices = damaged.vertices.copy()
    rounded = vertices[:, 1] > 0.0
    vertices[rounded] = np.round(vertices[rounded], 6)
    return Damaged(vertices, damaged.faces, damaged.where)


# --- degenerate faces -----------------------------------------------------------------------------


def faces_with_a_corner_twice(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, faces=np.concatenate([mesh.faces[:9, [0, 1, 1]], mesh.faces]))


def flat_faces(mesh: TriangleMesh) -> Damaged:
    """Triangles of an edge and its middle, which belongs to no other face."""
    ends = mesh.edges[::40]
    middles = mesh.vertices[ends].mean(axis=1)
    numbers = mesh.n_vertices + np.arange(len(ends))
    return _damaged(
        mesh,
        _with_points(mesh, middles),
        np.concatenate([mesh.faces, np.column_stack([ends, numbers])]),
    )


def _split_vertex(mesh: TriangleMesh, apart: float) -> Damaged:
    """Make two of a vertex, half of its faces each, joined by two needles."""
    v = 17
    ring = []  # its neighbours, counterclockwise
    following = {}
    for face in mesh.faces[(mesh.faces == v).any(axis=1)].tolist():
        at = face.index(v)
        following[face[(at + 1) % 3]] = face[(at + 2) % 3]
    neighbour = next(iter(following))
    while neighbour not in ring:
        ring.append(neighbour)
        neighbour = following[neighbour]
    half = ring[: len(ring) // 2 + 1]
    new = mesh.n_vertices
    faces = mesh.faces.tolist()
    for face in faces:
        if v in face and all(corner == v or corner in half for corner in face):
            face[face.index(v)] = new
    faces += [[v, half[0], new], [new, half[-1], v]]
    step = apart * (mesh.vertices[half[len(half) // 2]] - mesh.vertices[v])
    return _damaged(mesh, _with_points(mesh, mesh.vertices[v] + step), faces)


def needles_of_no_length(mesh: TriangleMesh) -> Damaged:
    return _split_vertex(mesh, 0.0)


def needles(mesh: TriangleMesh) -> Damaged:
    return _split_vertex(mesh, 1e-9)


def caps(mesh: TriangleMesh) -> Damaged:
    """The middle of an edge, a corner on its one side only, and a flat face between."""
    f, _, i, j, a, _ = _hinge(mesh)
    m = mesh.n_vertices
    faces = [face for number, face in enumerate(mesh.faces.tolist()) if number != f]
    middle = mesh.vertices[[i, j]].mean(axis=0)
    return _damaged(mesh, _with_points(mesh, middle), [*faces, [i, m, a], [m, j, a], [j, m, i]])


def t_junction(mesh: TriangleMesh) -> Damaged:
    """The same without the flat face: a crack of no width."""
    damaged = caps(mesh)
    return _damaged(mesh, damaged.vertices, damaged.faces[:-1])


def t_junctions_on_both_sides(mesh: TriangleMesh) -> Damaged:
    """One side of an edge has corners at its first third, the other at its second."""
    f, g, i, j, a, b = _hinge(mesh)
    m, n = mesh.n_vertices, mesh.n_vertices + 1
    faces = [face for number, face in enumerate(mesh.faces.tolist()) if number not in (f, g)]
    start, end = mesh.vertices[[i, j]]
    points = start + (end - start) / 3.0, start + 2.0 * (end - start) / 3.0
    faces += [[i, m, a], [m, j, a], [j, n, b], [n, i, b]]
    return _damaged(mesh, _with_points(mesh, *points), faces)


def t_junctions_and_seams(mesh: TriangleMesh) -> Damaged:
    """All faces loose, and T-junctions among them."""
    damaged = t_junctions_on_both_sides(mesh)
    corners = np.array(damaged.faces)
    where = np.full(mesh.n_vertices, -1)
    flat = corners.reshape(-1)
    old = flat < mesh.n_vertices
    where[flat[old][::-1]] = np.flatnonzero(old)[::-1]
    loose = np.arange(corners.size).reshape(-1, 3)
    return Damaged(damaged.vertices[flat], loose.tolist(), where)


# --- orientation ----------------------------------------------------------------------------------


def faces_turned_at_random(mesh: TriangleMesh) -> Damaged:
    turned = _random().random(mesh.n_faces) < 0.3
    return _damaged(mesh, faces=np.where(turned[:, None], mesh.faces[:, ::-1], mesh.faces))


def one_half_turned(mesh: TriangleMesh) -> Damaged:
    turned = _centroids(mesh)[:, 0] > 0.0
    return _damaged(mesh, faces=np.where(turned[:, None], mesh.faces[:, ::-1], mesh.faces))


def inside_out(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, faces=mesh.faces[:, ::-1])


def mirrored(mesh: TriangleMesh) -> Damaged:
    """Coordinates mirrored, faces not: an isometry, inside out."""
    return _damaged(mesh, mesh.vertices * np.array([-1.0, 1.0, 1.0]))


# --- coordinates ----------------------------------------------------------------------------------


def scaled_up(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, 1e12 * mesh.vertices, scale=1e12)


def scaled_down(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, 1e-12 * mesh.vertices, scale=1e-12)


def huge(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, 1e30 * mesh.vertices, scale=1e30)


def tiny(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, 1e-30 * mesh.vertices, scale=1e-30)


def moved_by_a_million(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, mesh.vertices + 1e6)


def moved_by_a_hundred_million(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, mesh.vertices - 1e8)


def huge_and_far_away(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, 1e38 * mesh.vertices + 1e41, scale=1e38)


def small_and_far_away(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, 1e-3 * mesh.vertices + 1e3, scale=1e-3)


def in_single_precision(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, mesh.vertices.astype(np.float32).astype(np.float64))


def seams_in_single_precision_far_away(mesh: TriangleMesh) -> Damaged:
    damaged = crossing_seams(mesh)
    vertices = (damaged.vertices + 300.0).astype(np.float32).astype(np.float64)
    return Damaged(vertices, damaged.faces, damaged.where)


HARMLESS: Mapping[Damage, str] = {
    vertices_shuffled: "",
    faces_shuffled: "",
    corners_rotated: "",
    unused_vertices_between: "dropped 1284 vertices of no face",
    unused_vertices_far_away: "dropped 2 vertices of no face",
    unused_vertices_without_place: "dropped 2 vertices of no face",
    faces_twice: "with the corners of others",
    faces_twice_and_turned: "with the corners of others",
    all_twice: "dropped 1280 faces lying exactly on others",
    all_twice_and_turned: "dropped 1280 faces lying exactly on others",
    a_patch_twice: "faces lying exactly on others",
    a_seam: "closed seams",
    crossing_seams: "closed seams",
    an_open_seam: "closed seams",
    loose_faces: "closed seams: merged 3198 border vertices",
    loose_faces_turned_at_random: "to agree with their neighbours",
    a_seam_that_gapes: "closed seams",
    loose_faces_that_gape: "closed seams",
    a_seam_in_six_digits: "closed seams",
    faces_with_a_corner_twice: "dropped 9 faces with a corner twice",
    flat_faces: "faces without area",
    needles_of_no_length: "merged 1 vertex into a neighbour at the same place",
    needles: "merged 1 vertex into a neighbour at the same place",
    caps: "closed cracks: split 1 face at 1 vertex",
    t_junction: "closed cracks: split 1 face at 1 vertex",
    t_junctions_on_both_sides: "closed cracks: split 2 faces at 2 vertices",
    t_junctions_and_seams: "closed cracks: split 2 faces at 2 vertices",
    faces_turned_at_random: "to agree with their neighbours",
    one_half_turned: "to agree with their neighbours",
    inside_out: "it was inside out",
    mirrored: "it was inside out",
    in_single_precision: "",
    seams_in_single_precision_far_away: "closed seams",
    scaled_up: "",
    scaled_down: "",
    huge: "",
    tiny: "",
    moved_by_a_million: "",
    moved_by_a_hundred_million: "",
    huge_and_far_away: "",
    small_and_far_away: "",
}
"""The surface is the same, and all distances on it; with what the user is told."""


# --- another surface ------------------------------------------------------------------------------


def a_fin(mesh: TriangleMesh) -> Damaged:
    """A third face on an edge."""
    _, _, i, j, a, _ = _hinge(mesh)
    tip = 2.0 * mesh.vertices[i] - mesh.vertices[a]
    faces = [*mesh.faces.tolist(), [i, j, mesh.n_vertices]]
    return _damaged(mesh, _with_points(mesh, tip), faces)


def an_interior_wall(mesh: TriangleMesh) -> Damaged:
    """A face through the inside, which touches the surface in its corners."""
    return _damaged(mesh, faces=[*mesh.faces.tolist(), [0, 200, 400]])


def glued_points(mesh: TriangleMesh) -> Damaged:
    """Two vertices far apart are one."""
    return _damaged(mesh, faces=np.where(mesh.faces == 7, 300, mesh.faces))


def a_wide_crack(mesh: TriangleMesh) -> Damaged:
    return _jittered(a_seam(mesh), 1e-3)


def a_wide_t_junction(mesh: TriangleMesh) -> Damaged:
    damaged = t_junction(mesh)
    vertices = damaged.vertices.copy()
    vertices[-1] += 0.003
    return _damaged(mesh, vertices, damaged.faces)


def coarse_for_its_place(mesh: TriangleMesh) -> Damaged:
    moved = (mesh.vertices + 1e4).astype(np.float32).astype(np.float64)
    return _damaged(mesh, moved)


def seven_digits_for_its_place(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, np.round(mesh.vertices + 1e3, 3))


def crossed_polygons(mesh: TriangleMesh) -> Damaged:
    """Two neighbouring faces as one quadrilateral whose corners are in the wrong order."""
    f, g, i, j, a, b = _hinge(mesh)
    faces = [face for number, face in enumerate(mesh.faces.tolist()) if number not in (f, g)]
    return _damaged(mesh, faces=[*faces, [i, j, a, b]])


def _strip(around: int = 24) -> tuple[FloatArray, list[list[int]]]:
    angles = 2.0 * np.pi * np.arange(around) / around
    rows = []
    for s in (-0.3, 0.3):
        reach = 1.0 + s * np.cos(angles / 2)
        height = s * np.sin(angles / 2)
        rows.append(np.stack([reach * np.cos(angles), reach * np.sin(angles), height], axis=1))
    faces = [[n, n + 1, around + n + 1, around + n] for n in range(around - 1)]
    last = around - 1
    return np.concatenate(rows), [*faces, [last, around, 0, around + last]]


def one_sided(mesh: TriangleMesh) -> Damaged:
    """A Möbius strip of quadrilaterals, and nothing of the mesh."""
    vertices, faces = _strip()
    return Damaged(vertices, faces, np.full(mesh.n_vertices, -1))


DISTORTING: Mapping[Damage, str] = {
    a_fin: "1 edge with more than two faces",
    an_interior_wall: "3 vertices at which the surface only touches itself",
    glued_points: "1 vertex at which the surface only touches itself",
    a_wide_crack: "border vertices nearly on another border",
    a_wide_t_junction: "1 border vertex nearly on another border",
    coarse_for_its_place: "distances are as uncertain",
    seven_digits_for_its_place: "distances are as uncertain",
    crossed_polygons: "1 face whose outline crosses itself",
    one_sided: "one side only",
}
"""The surface is another one, in a way that nobody can undo; with what the user is told."""


# --- no surface -----------------------------------------------------------------------------------


def not_a_number(mesh: TriangleMesh) -> Damaged:
    vertices = mesh.vertices.copy()
    vertices[33, 1] = np.nan
    return _damaged(mesh, vertices)


def infinite(mesh: TriangleMesh) -> Damaged:
    vertices = mesh.vertices.copy()
    vertices[44, 2] = np.inf
    return _damaged(mesh, vertices)


def on_a_line(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, mesh.vertices * np.array([1.0, 0.0, 0.0]))


def in_a_point(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, mesh.vertices * 0.0 + 3.0)


def beyond_numbers(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, mesh.vertices * 1e90)


def below_numbers(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, mesh.vertices * 1e-90)


def lost_in_single_precision(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, (3e1 * mesh.vertices + 1e8).astype(np.float32).astype(np.float64))


def lost_in_six_digits(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, np.round(mesh.vertices + 1e5, 0))


def without_faces(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, faces=[])


def a_vertex_too_far(mesh: TriangleMesh) -> Damaged:
    return _damaged(mesh, faces=[*mesh.faces.tolist(), [0, 1, mesh.n_vertices]])


HOPELESS: Mapping[Damage, str] = {
    not_a_number: "vertex 33 has a coordinate that is not a finite number",
    infinite: "vertex 44 has a coordinate that is not a finite number",
    on_a_line: "no face has an area",
    in_a_point: "no extent",
    beyond_numbers: "too large or too small",
    below_numbers: "too large or too small",
    lost_in_single_precision: "its form is lost; move it to the origin",
    lost_in_six_digits: "its form is lost; move it to the origin",
    without_faces: "no faces",
    a_vertex_too_far: "refers to vertex 642",
}
"""There is no surface to speak of; with the reason that the user is given."""
