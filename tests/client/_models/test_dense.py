"""Dense maps between vertices: values of the target's vertices at the images."""

import isomatch
import numpy as np
import pytest

DENSE = isomatch.DenseCorrespondence(
    hypothesis=0,
    source=(4, 7),
    target=(1, 3),
    faces=((0, 1, 2), (3, 1, 2)),
    barycentric=((0.25, 0.5, 0.25), (1.0, 0.0, 0.0)),
    inverse=isomatch.InverseCorrespondence(
        target=(0, 1, 2, 3),
        source=(4, 4, 7, 7),
        faces=((4, 5, 7),) * 4,
        barycentric=((0.4, 0.3, 0.3), (0.2, 0.2, 0.6), (0.0, 0.0, 1.0), (0.5, 0.25, 0.25)),
    ),
)


def test_images_are_arrays() -> None:
    assert DENSE.image_faces.tolist() == [[0, 1, 2], [3, 1, 2]]
    assert DENSE.image_faces.dtype == np.int64
    np.testing.assert_array_equal(DENSE.image_weights.sum(axis=1), 1.0)


def test_values_of_vertices_are_interpolated() -> None:
    np.testing.assert_allclose(DENSE.interpolate([0.0, 2.0, 4.0, 9.0]), [2.0, 9.0])
    positions = np.arange(12.0).reshape(4, 3)
    expected = [0.25 * positions[0] + 0.5 * positions[1] + 0.25 * positions[2], positions[3]]
    np.testing.assert_allclose(DENSE.interpolate(positions), expected)
    assert DENSE.interpolate(np.ones((4, 2, 5))).shape == (2, 2, 5)


@pytest.mark.parametrize("values", [1.0, [0.0, 1.0, 2.0]])
def test_every_corner_needs_a_value(values: object) -> None:
    with pytest.raises(ValueError, match="has a vertex 3"):
        DENSE.interpolate(np.array(values))


def test_results_with_vertices_alone_are_read_and_have_no_images() -> None:
    old = isomatch.DenseCorrespondence(hypothesis=0, source=(4, 7), target=(1, 3))
    assert old.image_faces.shape == old.image_weights.shape == (0, 3)
    with pytest.raises(ValueError, match="match again"):
        old.interpolate(np.zeros(4))
    with pytest.raises(ValueError, match="match again"):
        _ = old.target_to_source


def test_the_directions_are_maps_of_all_vertices_of_either_surface() -> None:
    there, back = DENSE.source_to_target, DENSE.target_to_source
    assert (there.vertices.tolist(), there.images.tolist()) == ([4, 7], [1, 3])
    assert (back.vertices.tolist(), back.images.tolist()) == ([0, 1, 2, 3], [4, 4, 7, 7])
    np.testing.assert_allclose(back.interpolate(np.arange(8.0)), [5.2, 6.0, 7.0, 5.0])


def test_the_majority_is_the_label_of_greatest_weight() -> None:
    labels = np.array(["-"] * 5 + ["leg", "-", "leg"])
    found = DENSE.target_to_source.majority(labels)
    assert found.tolist() == ["leg", "leg", "leg", "-"]
    with pytest.raises(ValueError, match="has a vertex 7"):
        DENSE.target_to_source.majority(labels[:7])
