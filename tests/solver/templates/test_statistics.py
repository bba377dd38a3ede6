"""Procrustes alignment and principal components whose answer is known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sklearn.decomposition import PCA

from solver.arrays import FloatArray
from solver.errors import OptionError
from solver.templates import generalised_procrustes, shape_statistics
from tests.solver import shapes


def moved(points: FloatArray, seed: int, scale: float = 1.0) -> FloatArray:
    chance = np.random.default_rng(seed)
    turn = Rotation.random(rng=chance).as_matrix()
    found: FloatArray = scale * points @ turn + chance.normal(size=3)
    return found


def without_motion(points: FloatArray, direction: FloatArray) -> FloatArray:
    """The part of a displacement that moves and turns nothing, to first order."""
    centred = points - points.mean(axis=0)
    motions = [np.tile(axis, (len(points), 1)) for axis in np.eye(3)]
    motions += [np.cross(axis, centred) for axis in np.eye(3)]
    basis = np.linalg.qr(np.stack([one.ravel() for one in motions], axis=1))[0]
    flat = direction.ravel()
    found: FloatArray = (flat - basis @ (basis.T @ flat)).reshape(-1, 3)
    return found / np.linalg.norm(found)


def test_moved_copies_have_no_variance() -> None:
    points = shapes.blob(2).vertices
    found = shape_statistics(np.stack([moved(points, seed) for seed in range(5)]))
    assert found.total_variance < 1e-20
    assert found.components.shape == (0, *points.shape)
    assert found.variances.shape == found.explained.shape == (0,)
    assert found.scores.shape == (5, 0)
    np.testing.assert_allclose(
        np.linalg.norm(found.mean, axis=1), np.linalg.norm(points - points.mean(axis=0), axis=1)
    )


@pytest.mark.parametrize("offset", [1e3, 1e6])
def test_rounding_errors_far_from_the_origin_are_no_component(offset: float) -> None:
    points = shapes.blob(2).vertices
    copies = [moved(points, seed) + offset * seed for seed in range(4)]
    assert len(shape_statistics(np.stack(copies)).components) == 0


def test_specimens_of_few_vertices_have_no_more_components_than_ways_to_differ() -> None:
    """Four vertices have 12 coordinates, and 6 ways to move together."""
    specimens = np.random.default_rng(4).normal(size=(20, 4, 3))
    found = shape_statistics(specimens)
    assert len(found.components) == 6
    assert found.explained.sum() == pytest.approx(1.0)


def test_scaled_copies_have_no_variance_if_size_does_not_count() -> None:
    points = shapes.blob(2).vertices
    copies = np.stack([moved(points, seed, scale) for seed, scale in enumerate([0.5, 1.0, 2.0])])
    np.testing.assert_allclose(shape_statistics(copies, True).total_variance, 0.0, atol=1e-20)
    assert shape_statistics(copies, False).total_variance > 0.1
    sizes = generalised_procrustes(copies).sizes
    np.testing.assert_allclose(sizes / sizes[1], [0.5, 1.0, 2.0])


def test_a_linear_family_has_its_direction_and_variance() -> None:
    points = shapes.blob(2).vertices
    direction = without_motion(points, np.random.default_rng(1).normal(size=points.shape))
    steps = 1e-4 * np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    family = np.stack([moved(points + step * direction, k) for k, step in enumerate(steps)])
    found = shape_statistics(family)
    np.testing.assert_allclose(found.variances[0], steps.var(ddof=1), rtol=1e-3)
    assert found.explained[0] == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_allclose(np.abs(found.scores[:, 0]), np.abs(steps), atol=1e-7)
    assert np.linalg.norm(found.components[0]) == pytest.approx(1.0)


@pytest.mark.parametrize("scale", [False, True])
def test_all_components_reproduce_every_specimen(scale: bool) -> None:
    chance = np.random.default_rng(2)
    points = shapes.blob(2).vertices
    specimens = np.stack([points + 0.05 * chance.normal(size=points.shape) for _ in range(6)])
    found = shape_statistics(specimens, scale)
    again = found.mean + np.einsum("nc,cvd->nvd", found.scores, found.components)
    np.testing.assert_allclose(again, found.alignment.positions, atol=1e-12)
    known = PCA(n_components=5).fit(found.alignment.positions.reshape(6, -1))
    np.testing.assert_allclose(found.variances, known.explained_variance_)
    np.testing.assert_allclose(found.explained, known.explained_variance_ratio_)
    flat = found.components.reshape(5, -1)
    np.testing.assert_allclose(flat @ flat.T, np.eye(5), atol=1e-12)


def test_alignment_is_no_worse_than_onto_any_single_specimen() -> None:
    chance = np.random.default_rng(3)
    points = shapes.blob(2).vertices
    specimens = np.stack(
        [moved(points + 0.2 * chance.normal(size=points.shape), seed) for seed in range(4)]
    )
    found = generalised_procrustes(specimens)
    best = ((found.positions - found.mean) ** 2).sum()
    centred = specimens - specimens.mean(axis=1, keepdims=True)
    for reference in centred:
        turns = [Rotation.align_vectors(reference, one)[0] for one in centred]
        turned = np.stack([turn.apply(one) for turn, one in zip(turns, centred, strict=True)])
        assert best <= ((turned - turned.mean(axis=0)) ** 2).sum() * (1.0 + 1e-9)


def test_one_specimen_has_no_components() -> None:
    found = shape_statistics(shapes.blob(2).vertices[None])
    assert found.components.shape == (0, len(found.mean), 3)
    assert found.total_variance == 0.0
    assert found.explained.shape == found.variances.shape == (0,)


def test_a_point_and_nothing_are_refused() -> None:
    with pytest.raises(OptionError, match="one point"):
        generalised_procrustes(np.zeros((2, 5, 3)))
    with pytest.raises(OptionError, match="no specimen"):
        generalised_procrustes(np.zeros((0, 5, 3)))
