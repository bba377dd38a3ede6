"""Measures of a fit: closed forms of strains, and what the score prefers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from solver.arrays import FloatArray
from solver.functional_maps import FunctionalMap
from solver.registration.alignment import Alignment
from solver.registration.fit import Fit, measure_fit, worse_by
from solver.registration.surface import Samples, SmoothSurface, commute_times
from solver.shape import Shape
from tests.solver import shapes

K = 40
MEASURES = st.floats(1e-4, 10.0)


def displaced(samples: Samples, matrix: FloatArray) -> Alignment:
    """Positions x of a source that go to x A."""
    return Alignment(samples.coefficients[:K] @ matrix, FunctionalMap(np.eye(K)), np.eye(3))


def fit_of(samples: Samples, matrix: FloatArray) -> Fit:
    return measure_fit(samples, samples, displaced(samples, matrix))[0]


def test_equal_surfaces_fit_exactly(surface: SmoothSurface) -> None:
    same = displaced(surface.samples, np.eye(3))
    fit, local = measure_fit(surface.samples, surface.samples, same, distances=True)
    everywhere = np.arange(len(surface.samples))
    np.testing.assert_array_equal(local.pairs.images, everywhere)
    np.testing.assert_array_equal(local.pairs.back, everywhere)
    for measure in fit.values.values():
        assert measure == pytest.approx(0.0, abs=1e-6)


def test_rotations_strain_nothing(surface: SmoothSurface) -> None:
    fit = fit_of(surface.samples, Rotation.from_rotvec([0.5, 1.0, -0.2]).as_matrix())
    assert fit.values["sheared"] == pytest.approx(0.0, abs=1e-6)
    assert fit.values["stretched"] == pytest.approx(0.0, abs=1e-9)
    assert fit.values["apart"] > 0.01


def test_the_first_form_is_that_of_the_derivatives(surface: SmoothSurface) -> None:
    samples, k = surface.samples, 30
    u, v = samples.derivatives(samples.coefficients[:k])
    form = samples.smoothed_first_form(k)
    for known, expected in zip(form, ((u, u), (u, v), (v, v)), strict=True):
        np.testing.assert_allclose(known, np.einsum("sd,sd->s", *expected), rtol=1e-12)
    assert samples.smoothed_first_form(k) is form
    assert samples.reflected().smoothed_first_form(k) is not form


@pytest.mark.parametrize("factor", [0.5, 1.1, 2.0])
def test_scaling_changes_areas_by_the_square_and_no_angles(
    surface: SmoothSurface, factor: float
) -> None:
    fit = fit_of(surface.samples, factor * np.eye(3))
    assert fit.values["sheared"] == pytest.approx(0.0, abs=1e-6)
    assert fit.values["stretched"] == pytest.approx(2.0 * abs(np.log(factor)), rel=1e-6)


@pytest.mark.parametrize("factor", [0.5, 1.2, 3.0])
def test_stretching_a_plane_in_one_direction(factor: float) -> None:
    """Singular values a and 1: conformal distortion (a + 1 / a) / 2, change of area a."""
    mesh = shapes.plane_grid(24, 17)
    # At the border the derivatives of eigenfunctions vanish across it.
    inside = np.abs(mesh.vertices - [0.75, 0.5, 0.0]).max(axis=1) < 0.4
    samples = SmoothSurface(Shape(mesh)).at(np.flatnonzero(inside))
    fit = fit_of(samples, np.diag([factor, 1.0, 1.0]))
    distortion = np.log(0.5 * (factor + 1.0 / factor))
    assert fit.values["sheared"] == pytest.approx(np.sqrt(2.0 * distortion), rel=1e-4)
    assert fit.values["stretched"] == pytest.approx(abs(np.log(factor)), rel=1e-4)


def test_a_reflection_turns_normals(surface: SmoothSurface) -> None:
    """Positions that are reflected have normals on the inside."""
    fit = fit_of(surface.samples, np.diag([-1.0, 1.0, 1.0]))
    assert fit.values["turned"] > 0.5


@given(st.lists(MEASURES, min_size=7, max_size=7), st.integers(0, 5), st.floats(0.1, 0.9))
def test_the_score_falls_with_each_local_measure(
    measures: list[float], place: int, factor: float
) -> None:
    better = list(measures)
    better[place] *= factor
    assert fit_with(better).score < fit_with(measures).score


def test_the_score_is_the_sum_of_logarithms() -> None:
    measures = [0.1, 0.02, 0.03, 0.04, 0.5, 0.6, 0.07]
    assert fit_with(measures).score == pytest.approx(np.log(np.prod(measures[:6])))
    assert np.isfinite(fit_with([0.0] * 7).score)


def fit_with(measures: list[float]) -> Fit:
    names = "apart", "turned", "sheared", "stretched", "bent_0", "bent_1", "distorted"
    return Fit(dict(zip(names, measures, strict=True)), frozenset({"distorted"}))


def test_what_has_no_partner_is_charged_with_the_occlusion() -> None:
    fit = Fit({"apart": 0.1, "turned": 0.2}, share=0.25, occlusion=-3.0)
    assert fit.score == pytest.approx(0.25 * np.log(0.02) - 0.75 * 3.0)
    further = fit.also({"strained": 0.5})
    assert list(further.measures) == ["apart", "turned", "strained"]
    assert further.score == pytest.approx(0.25 * np.log(0.01) - 0.75 * 3.0)


def test_the_local_measures_add_up_to_the_difference_of_scores(surface: SmoothSurface) -> None:
    """To first order."""
    stretched = np.diag([1.3, 1.0, 0.9])
    one, other = (
        measure_fit(surface.samples, surface.samples, displaced(surface.samples, matrix))
        for matrix in (stretched, stretched @ np.diag([1.005, 1.0, 1.0]))
    )
    difference = one[0].score - other[0].score
    assert worse_by(one[1].densities, other[1].densities).mean() == pytest.approx(
        difference, rel=0.05
    )
    np.testing.assert_allclose(
        worse_by(other[1].densities, one[1].densities),
        -worse_by(one[1].densities, other[1].densities),
    )


def test_commute_times_are_those_of_the_metric(surface: SmoothSurface) -> None:
    vertices = surface.samples.vertices[:20]
    metric = Shape(surface.mesh).metric("commute_time").distances(vertices)[:, vertices]
    found = commute_times(surface.samples, np.arange(20))
    assert found.mean() == pytest.approx(1.0)
    np.testing.assert_allclose(found, metric / metric.mean(), atol=0.02)
