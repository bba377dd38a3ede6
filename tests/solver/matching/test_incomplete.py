"""Detection of what is incomplete, without a word from the user."""

from dataclasses import replace

import numpy as np
import pytest

from bench.map_error import map_error
from bench.overlap import generated_overlap
from solver.arrays import BoolArray, FloatArray, IntArray
from solver.matching import Match, MatchOptions, match
from solver.mesh import triangle_mesh
from solver.registration.confidence import CONTRADICTED, RIVAL
from solver.shape import Shape, euclidean_farthest_points
from synthetic import human, with_holes
from tests.solver import shapes
from tests.solver.matching.test_overlap import body

RESOLUTION = 1200
"""Of coarser bodies without limbs, the mirror image as a whole fits as well as the truth."""

OPTIONS = MatchOptions(points=16, dense=True)


@pytest.fixture(scope="module")
def rest() -> FloatArray:
    """Places of all bodies' vertices, at rest: between -½ and ½ of the height."""
    places = human("standing", resolution=RESOLUTION, seed=1).rest
    centred: FloatArray = (places - places.mean(axis=0)) / np.ptp(places[:, 1])
    return centred


def limbs(rest: FloatArray) -> tuple[BoolArray, BoolArray, BoolArray]:
    """(V,) vertices of the lower legs, of the arms, and of the right half."""
    low = rest[:, 1] < rest[:, 1].min() + 0.25
    return low, np.abs(rest[:, 0]) > np.abs(rest[:, 0]).max() - 0.15, rest[:, 0] > 0.0


def errors(found: Match, source: IntArray, target: Shape, there: IntArray) -> FloatArray:
    """(n,) geodesic errors over √area of the vertices that both have and the map has."""
    assert found.dense is not None
    points = source[found.dense.source]
    common = np.isin(points, there)
    truth = np.searchsorted(there, points[common])
    distances = target.metric("geodesic").distances(truth)
    away: FloatArray = distances[np.arange(len(truth)), found.dense.target[common]] / target.size
    return away


def test_surfaces_that_lack_different_limbs_overlap(rest: FloatArray) -> None:
    """Each lacks the leg and the arm of one side, so that as wholes they fit mirrored."""
    legs, arms, right = limbs(rest)
    ours = body("walking", (legs | arms) & right, 1.0)
    theirs = body("standing", (legs | arms) & ~right, 1.0)
    found = match(ours[0], theirs[0], OPTIONS)
    assert found.overlap is not None
    assert found.overlap.part == "both"
    assert errors(found, ours[1], *theirs).mean() < 0.05
    whole = match(ours[0], theirs[0], replace(OPTIONS, partial="none"))
    assert whole.overlap is None
    assert errors(whole, ours[1], *theirs).mean() > 0.2


def test_surfaces_of_given_scale_overlap_as_others_do(rest: FloatArray) -> None:
    """Those of the test above, in the same unit of length."""
    legs, arms, right = limbs(rest)
    ours = body("walking", (legs | arms) & right, 1.0)
    theirs = body("standing", (legs | arms) & ~right, 1.0)
    source, target = (Shape(one[0].mesh, normalise=False) for one in (ours, theirs))
    found = match(source, target, OPTIONS)
    assert found.overlap is not None
    assert found.overlap.scale == pytest.approx(1.0)
    assert errors(found, ours[1], target, theirs[1]).mean() < 0.05


def test_surfaces_that_fit_otherwise_too_are_doubted(rest: FloatArray) -> None:
    """Each is all but the mirror image of the other, which covers more than the truth does."""
    legs, arms, right = limbs(rest)
    ours = body("walking", np.where(right, legs, arms), 1.0)
    theirs = body("standing", np.where(right, arms, legs), 1.0)
    found = match(ours[0], theirs[0], OPTIONS)
    assert found.confidence is not None
    assert found.confidence.probability < 0.5
    assert RIVAL in found.confidence.reasons


def test_bodies_without_opposite_sides_are_not_mirrored() -> None:
    """One lacks its left side, and one its right: the mirror image covers nearly all of both."""
    _, source, target = generated_overlap(6, opposite=True)
    found = match(source.shape, target.shape, OPTIONS)
    assert found.overlap is not None
    assert found.dense is not None
    assert map_error(source, target, found.dense).direct < 0.05


def test_wholes_with_boundaries_that_contradict_a_landmark_are_doubted() -> None:
    """Though registrations as wholes and as parts agree."""
    blob = shapes.blob(3)
    height = blob.vertices[:, 2]
    kept = np.flatnonzero(height < np.quantile(height, 0.93))
    faces = blob.faces[np.isin(blob.faces, kept).all(axis=1)]
    kept = np.unique(faces)
    cut = triangle_mesh(blob.vertices[kept], np.searchsorted(kept, faces))
    places = cut.vertices
    bent = triangle_mesh(places * (1.0 + 0.06 * np.sin(3.0 * places[:, [1, 2, 0]])), cut.faces)
    *right, wrong = euclidean_farthest_points(places, 9)[[0, 1, 2, 3, 4, 5, 8]].tolist()
    away = np.linalg.norm(places - places[wrong], axis=1) / np.sqrt(cut.area)
    marks = (*((one, one) for one in right), (wrong, int(np.abs(away - 0.25).argmin())))
    found = match(Shape(cut), Shape(bent), MatchOptions(points=16, landmarks=marks))
    assert found.overlap is None
    assert any(one.startswith("landmarks.6") for one in found.warnings)
    assert found.confidence is not None
    assert CONTRADICTED in found.confidence.reasons
    assert found.confidence.probability <= 0.5


def test_a_surface_with_very_many_small_holes_is_whole(rest: FloatArray) -> None:
    """Of which the boundary is many times as long as that of a part."""
    nothing, holes = np.zeros(len(rest), dtype=np.bool_), list[int]()
    mesh, other = (body(pose, nothing, 1.0)[0].mesh for pose in ("walking", "standing"))
    touched = np.zeros(mesh.n_vertices, dtype=np.bool_)
    for number, face in enumerate(mesh.faces):
        if not touched[face].any():
            touched[face] = True
            holes.append(number)
    holed = Shape(triangle_mesh(mesh.vertices, np.delete(mesh.faces, holes, axis=0)))
    assert len(holes) > 200
    assert holed.mesh.area < 0.95 * mesh.area
    found = match(holed, Shape(other), OPTIONS)
    assert found.overlap is None
    assert found.confidence is not None
    assert found.confidence.probability > 0.9


def test_surfaces_with_small_holes_are_whole(rest: FloatArray) -> None:
    whole = np.zeros(len(rest), dtype=np.bool_)
    ours, theirs = (
        Shape(with_holes(body(pose, whole, 1.0)[0].mesh, 5, 0.05, seed=seed, least=3).mesh)
        for seed, pose in enumerate(("walking", "standing"))
    )
    assert min(one.mesh.relative_boundary for one in (ours, theirs)) > 0.5
    found = match(ours, theirs, OPTIONS)
    assert found.overlap is None
    assert found.dense is not None
    assert len(found.dense.source) == ours.n_vertices
    assert found.confidence is not None
    assert found.confidence.probability > 0.9


def bent_sheet(columns: int, rows: int, bend: float) -> Shape:
    """A sheet with hills and hollows, bent upwards or downwards at its ends."""
    flat = shapes.plane_grid(columns, rows)
    x, y, _ = flat.vertices.T
    height = 0.12 * np.sin(3.0 * x + 1.0) * np.cos(4.0 * y) + bend * (x - 0.75) ** 2
    height += 0.1 * np.exp(-((x - 1.1) ** 2 + (y - 0.7) ** 2) / 0.02)
    height -= 0.1 * np.exp(-((x - 0.4) ** 2 + (y - 0.3) ** 2) / 0.03)
    return Shape(triangle_mesh(np.stack([x, y, height], axis=1), flat.faces))


@pytest.mark.parametrize("partial", ["none", "detected"])
def test_sheets_that_are_bent_to_opposite_sides_are_whole(partial: str) -> None:
    """The volume that a sheet encloses with its middle changes its sign, its winding does not."""
    ours, theirs = bent_sheet(54, 36, 0.3), bent_sheet(60, 40, -0.3)
    found = match(ours, theirs, replace(OPTIONS, partial=partial))
    assert found.overlap is None
    assert found.confidence is not None
    assert found.confidence.is_sure
    assert found.dense is not None
    corners = theirs.mesh.vertices[theirs.mesh.vertices_of(found.dense.faces.ravel())]
    images = np.einsum("vc,vcd->vd", found.dense.barycentric, corners.reshape(-1, 3, 3))
    away = np.linalg.norm(images - ours.mesh.vertices[found.dense.source], axis=1)
    assert np.median(away) < 0.15 * ours.size
    beside = np.linalg.norm((images - ours.mesh.vertices[found.dense.source])[:, :2], axis=1)
    assert beside.mean() < 0.05 * ours.size
