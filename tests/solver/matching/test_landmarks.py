"""Landmarks of a match."""

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.errors import OptionError
from solver.matching import MatchOptions, build_level, match
from solver.mesh import triangle_mesh
from solver.registration.confidence import CONTRADICTED
from solver.shape import Shape
from synthetic import SyntheticShape, correspondence, human
from tests.solver import shapes

Pair = tuple[SyntheticShape, SyntheticShape]


@pytest.fixture(scope="module")
def figures() -> Pair:
    """A symmetric person, in two poses."""
    return human("standing", resolution=600, seed=1), human("walking", resolution=700, seed=2)


@pytest.fixture(scope="module")
def pair(figures: Pair) -> tuple[Shape, Shape]:
    source, target = (Shape(triangle_mesh(one.vertices, one.faces)) for one in figures)
    return source, target


def mirrored(figure: SyntheticShape) -> IntArray:
    """The vertex on the other side of the body of each vertex."""
    apart = np.linalg.norm((figure.rest * [-1.0, 1.0, 1.0])[:, None] - figure.rest, axis=2)
    nearest: IntArray = np.argmin(apart, axis=1).astype(np.int64)
    return nearest


@pytest.mark.parametrize("crossed", [False, True])
def test_landmarks_choose_between_symmetric_matches(
    figures: Pair, pair: tuple[Shape, Shape], crossed: bool
) -> None:
    """One hand, and what is in front, decide which of the two symmetric solutions it is."""
    truth = correspondence(*figures)
    other = mirrored(figures[1])[truth]
    wanted, unwanted = (other, truth) if crossed else (truth, other)
    rest = figures[0].rest
    hand, front = int(np.argmax(rest[:, 0])), int(np.argmax(rest @ [0.0, 0.2, 1.0]))
    known = tuple((vertex, int(wanted[vertex])) for vertex in (hand, front))
    found = match(*pair, MatchOptions(points=24, landmarks=known))
    distances = pair[1].metric("geodesic").distances(found.best.target)
    right, wrong = (
        distances[np.arange(24), where[found.best.source]].mean() for where in (wanted, unwanted)
    )
    assert right < 0.1 < wrong
    for answer in (found.best, *found.alternatives):
        pairs = dict(zip(answer.source.tolist(), answer.target.tolist(), strict=True))
        assert set(known) <= set(pairs.items())
    assert found.levels[-1].lower_bound <= found.best.energy


@pytest.mark.parametrize("partial", ["none", "source"])
def test_a_landmark_that_the_surfaces_contradict_is_named(
    figures: Pair, pair: tuple[Shape, Shape], partial: str
) -> None:
    truth, rest = correspondence(*figures), figures[0].rest
    head, hand, foot = (
        int((rest @ axis).argmax()) for axis in np.array([[0, 1], [1, 0], [0, -1]]) @ np.eye(2, 3)
    )
    good = tuple((vertex, int(truth[vertex])) for vertex in (head, hand))
    known = match(*pair, MatchOptions(points=12, partial=partial, landmarks=good))
    assert known.confidence is not None
    assert not any(one.startswith("landmarks") for one in known.warnings)
    wrong = foot, int(truth[int(rest[:, 0].argmin())])
    found = match(*pair, MatchOptions(points=12, partial=partial, landmarks=(*good, wrong)))
    assert found.confidence is not None
    (warning,) = (one for one in found.warnings if one.startswith("landmarks"))
    assert warning.startswith("landmarks.2: registered, its source vertex is")
    assert CONTRADICTED in found.confidence.reasons
    assert found.confidence.probability <= 0.5 < known.confidence.probability


@pytest.mark.parametrize("occlusion_cost", [None, 0.5])
def test_as_many_landmarks_as_points(
    figures: Pair, pair: tuple[Shape, Shape], occlusion_cost: float | None
) -> None:
    truth = correspondence(*figures)
    vertices = pair[0].sampling("geodesic", 32).indices
    known = tuple((int(x), int(truth[x])) for x in vertices)
    options = MatchOptions(points=32, landmarks=known, occlusion_cost=occlusion_cost)
    found = match(*pair, options)
    pairs = set(zip(found.best.source.tolist(), found.best.target.tolist(), strict=True))
    assert pairs <= set(known)
    assert found.certified
    assert len(pairs) == 32 or occlusion_cost is not None


def test_only_their_own_partners_are_allowed() -> None:
    mesh = shapes.blob(2)
    shape = Shape(mesh)
    known = np.array([[5, 9], [100, 41]])
    options = MatchOptions(points=4, coarse_points=4, landmarks=((5, 9), (100, 41)))
    level = build_level(shape, shape, 0, (4, 6), options, known)
    assert level.source.vertices[:2].tolist() == [5, 100]
    assert level.target.vertices[:2].tolist() == [9, 41]
    expected = np.zeros((4, 6), dtype=bool)
    expected[0, 0] = expected[1, 1] = True
    expected[2:, 2:] = True
    np.testing.assert_array_equal(level.allowed(), expected)
    candidates = level.all_candidates()
    assert len(candidates) == 2 + 2 * 4
    assert expected[candidates[:, 0], candidates[:, 1]].all()


def test_landmarks_are_given_in_the_users_numbers() -> None:
    mesh = shapes.blob(2)
    other, where = shapes.permuted(mesh, seed=3)
    known = tuple((v, int(where[v])) for v in (3, 77))
    found = match(Shape(mesh), Shape(other), MatchOptions(points=8, landmarks=known))
    np.testing.assert_array_equal(found.best.target, where[found.best.source])
    np.testing.assert_allclose(found.best.energy, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("landmarks", "field", "options"),
    [
        (((1, 2), (1, 3)), "landmarks.1.0", {}),
        (((1, 2), (4, 2)), "landmarks.1.1", {}),
        (tuple((i, i) for i in range(9)), "landmarks", {"points": 8}),
        (tuple((i, i) for i in range(33)), "landmarks", {"points": 64}),
        (((1, 2),), "landmarks", {"objective": "linf", "points": 8}),
        (((0, 0), (1, 10**6)), "landmarks.1.1", {}),
        (((-1, 0),), "landmarks.0.0", {}),
    ],
)
def test_invalid_landmarks_are_refused(
    landmarks: tuple[tuple[int, int], ...], field: str, options: dict[str, object]
) -> None:
    shape = Shape(shapes.blob(2))
    with pytest.raises(OptionError) as refusal:
        match(shape, shape, MatchOptions(landmarks=landmarks, **options))  # type: ignore[arg-type]
    assert refusal.value.field == field


def test_merged_landmarks_are_refused() -> None:
    """A seam's two vertices are one after repair."""
    mesh = shapes.blob(2)
    vertices = np.concatenate([mesh.vertices, mesh.vertices[:1]])
    faces = mesh.faces.copy()
    row, corner = np.argwhere(faces == 0)[0]
    faces[row, corner] = len(mesh.vertices)
    seamed = Shape(triangle_mesh(vertices, faces))
    known = ((0, 0), (len(mesh.vertices), 5))
    with pytest.raises(OptionError, match="merged") as refusal:
        match(seamed, Shape(mesh), MatchOptions(points=8, landmarks=known))
    assert refusal.value.field == "landmarks.1.0"
