"""Dissimilarities: what they are zero for, what does not change them, what they are made of."""

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.spatial.distance import squareform

from solver.arrays import FloatArray
from solver.errors import OptionError
from solver.mesh import TriangleMesh, triangle_mesh
from solver.optimisation.exact import minimax_correspondence
from solver.shape import Shape
from solver.similarity import (
    SAMPLINGS,
    Signature,
    SignatureCollection,
    SimilarityOptions,
    dissimilarities,
    number_of_pairs,
    pairs_between,
    retrieval_scores,
    signature,
)
from solver.similarity.qap import MAX_POINTS
from tests.solver.shapes import blob, cube, icosphere, moved, permuted, plane_grid, torus, tube

OPTIONS = [
    SimilarityOptions(),
    SimilarityOptions(metric="geodesic", points=5),
    SimilarityOptions(metric="diffusion", first_order_weight=0.3),
    SimilarityOptions(objective="linf", points=8),
]


def signatures(meshes: Sequence[TriangleMesh], options: SimilarityOptions) -> list[Signature]:
    return [signature(Shape(mesh, eigenpairs=60), options) for mesh in meshes]


def values(meshes: Sequence[TriangleMesh], options: SimilarityOptions) -> FloatArray:
    return matrix(signatures(meshes, options), options)


def matrix(found: Sequence[Signature], options: SimilarityOptions) -> FloatArray:
    """(K, K) dissimilarities of all pairs."""
    pairs = pairs_between(len(found), 0, number_of_pairs(len(found)))
    both = SignatureCollection.of(found, options.points)
    return np.asarray(squareform(dissimilarities(both, pairs, options).costs))


def noisy(mesh: TriangleMesh, seed: int) -> TriangleMesh:
    """The mesh with its vertices moved, renumbered, rotated, scaled."""
    random = np.random.default_rng(seed)
    edge = np.linalg.norm(
        mesh.vertices[mesh.faces[:, 0]] - mesh.vertices[mesh.faces[:, 1]], axis=1
    ).mean()
    vertices = mesh.vertices + 0.1 * edge * random.standard_normal(mesh.vertices.shape)
    other = permuted(triangle_mesh(vertices, mesh.faces), seed)[0]
    return moved(other, seed, scale=float(np.exp(random.normal())))


@pytest.mark.parametrize("options", OPTIONS)
def test_it_is_a_dissimilarity(options: SimilarityOptions) -> None:
    found = values([blob(2), torus(16, 8), blob(2), cube(4)], options)
    assert found[0, 2] == 0.0
    others = found[np.triu_indices(4, 1)][[0, 2, 3, 4, 5]]
    assert (others > 0.0).all()
    assert np.isfinite(found).all()


@pytest.mark.parametrize("options", OPTIONS)
def test_it_does_not_change_when_shapes_are_moved_scaled_or_renumbered(
    options: SimilarityOptions,
) -> None:
    # A cube has equal vertices to choose from, a box has not.
    box = triangle_mesh(cube(5).vertices * [1.0, 1.5, 2.2], cube(5).faces)
    shapes = [blob(2), box]
    same = [moved(permuted(blob(2), 3)[0], 1, scale=7.0), moved(box, 2, scale=0.01)]
    found = values([shapes[0], same[0], shapes[1], same[1]], options)
    assert found[0, 1] < 1e-7
    assert found[0, 2] == pytest.approx(found[1, 2], rel=1e-6)
    assert found[0, 2] == pytest.approx(found[0, 3], rel=1e-6)


def test_the_greatest_distortion_is_that_of_minimax_correspondences() -> None:
    options = SimilarityOptions(objective="linf", points=7)
    first, second = (full.first(7) for full in signatures([blob(2), torus(16, 8)], options))
    both = SignatureCollection.of([first, second], options.points)
    found = dissimilarities(both, np.array([[0, 1], [1, 0]]), options)
    least = [
        minimax_correspondence(first.distances[kind], second.distances[kind]).value
        for kind in range(len(SAMPLINGS))
    ]
    np.testing.assert_array_equal(found.costs, min(least))
    np.testing.assert_array_equal(found.samplings, np.argmin(least))


def test_a_sphere_that_is_meshed_anew_is_alike_by_its_descriptors() -> None:
    """Descriptors of spheres are constant, but for their meshes."""
    options = SimilarityOptions(first_order_weight=1.0)
    found = values([icosphere(3), icosphere(4), torus(16, 8), cube(4)], options)
    assert found[0, 1] < 0.1
    assert found[0, 2:].min() > 3.0 * found[0, 1]


def test_the_bijection_has_the_distortion_that_is_said() -> None:
    options = SimilarityOptions(first_order_weight=0.2)
    first, second = (full.first(6) for full in signatures([blob(2), cube(5)], options))
    both = SignatureCollection.of([first, second], options.points)
    found = dissimilarities(both, np.array([[0, 1]]), options)
    kind, partners = found.samplings[0], found.partners[0]
    a, b = first.distances[kind], second.distances[kind][np.ix_(partners, partners)]
    relative = ((a - b) ** 2).sum() / (0.5 * ((a**2).sum() + (b**2).sum()))
    f, g = first.descriptors[kind], second.descriptors[kind]
    every = both.descriptors.reshape(-1, both.descriptors.shape[-1])
    unit = np.sqrt(((every - every.mean(axis=0)) ** 2).sum(axis=1).mean())
    described = np.linalg.norm(f - g[partners], axis=1).mean() / unit
    assert found.costs[0] == pytest.approx(relative + 0.2 * described, rel=1e-9)


def test_classes_are_told_apart_through_noise() -> None:
    solids = {"blob": blob(2), "torus": torus(), "sheet": plane_grid(), "tube": tube(8, 40, 0.1)}
    labels = [name for name in solids for _ in range(3)]
    meshes = [noisy(solids[name], seed) for seed, name in enumerate(labels)]
    shapes = [Shape(mesh, eigenpairs=60) for mesh in meshes]
    for options in (SimilarityOptions(), SimilarityOptions(points=8, objective="linf")):
        found = [signature(shape, options) for shape in shapes]
        scores = retrieval_scores(matrix(found, options), labels)
        assert scores.mean_average_precision == scores.precision_at_1 == 1.0


def test_pairs_are_those_of_the_upper_triangle() -> None:
    for count in (2, 3, 7, 40):
        every = np.stack(np.triu_indices(count, 1), axis=1)
        assert number_of_pairs(count) == len(every)
        assert (pairs_between(count, 0, len(every)) == every).all()
        for first, last in ((0, 1), (len(every) // 3, len(every) // 2), (len(every) - 1,) * 2):
            assert (pairs_between(count, first, last) == every[first:last]).all()


def test_what_is_stored_is_what_was_computed() -> None:
    options = SimilarityOptions(first_order_weight=0.1)
    (found,) = signatures([blob(2)], options)
    again = Signature.from_bytes(found.to_bytes())
    both = SignatureCollection.from_bytes(SignatureCollection.of([found, again], 10).to_bytes())
    for k in range(2):
        assert (both.distances[k] == found.distances).all()
        assert (both.descriptors[k] == found.descriptors).all()
    assert (again.vertices == found.vertices).all()
    assert found.vertices.shape == (len(SAMPLINGS), MAX_POINTS)
    assert (found.first(4).distances == found.distances[:, :4, :4]).all()
    for wrong in (b"", b"PK\x03\x04", found.to_bytes()[:-40]):
        with pytest.raises(ValueError, match="not a stored signature"):
            Signature.from_bytes(wrong)


def test_a_shape_needs_as_many_vertices_as_points() -> None:
    with pytest.raises(OptionError) as refused:
        signature(Shape(triangle_mesh(np.eye(3), np.array([[0, 1, 2]]))), SimilarityOptions())
    assert refused.value.field == "points"
    few = signature(Shape(triangle_mesh(np.eye(3), np.array([[0, 1, 2]]))), SimilarityOptions(3))
    with pytest.raises(OptionError):
        SignatureCollection.of([few], 4)


@pytest.mark.parametrize(
    ("field", "value"),
    [("points", 2), ("points", 11), ("objective", "l1"), ("first_order_weight", -1.0)],
)
def test_options_out_of_range_are_refused(field: str, value: object) -> None:
    with pytest.raises(OptionError) as refused:
        SimilarityOptions(**{field: value})  # type: ignore[arg-type]
    assert refused.value.field == field
