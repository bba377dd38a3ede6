"""Shape: normalisation, laziness, and unknown names."""

from collections.abc import Callable

import numpy as np
import pytest

from solver.errors import OptionError
from solver.mesh import largest_component
from solver.shape import GeodesicMetric, Shape
from solver.shape.choices import DESCRIPTORS, METRICS, Diffusion, HeatKernelSignature
from solver.shape.geodesics import GEODESIC_METHODS, geodesics
from solver.shape.laplacian import laplace_beltrami_spectrum
from tests.solver import shapes

POINTS = np.array([0, 33, 444, 600])


@pytest.mark.parametrize("name", METRICS)
def test_normalised_samples_do_not_depend_on_size(name: str) -> None:
    small = Shape(shapes.blob())
    large = Shape(shapes.moved(shapes.blob(), seed=4, scale=1e3))
    assert small.surface.area == pytest.approx(1.0)
    np.testing.assert_array_equal(
        large.sampling(name, 12).indices, small.sampling(name, 12).indices
    )


def test_without_normalisation_lengths_are_the_users() -> None:
    mesh = shapes.moved(shapes.blob(), seed=4, scale=10.0)
    plain, unit = Shape(mesh, normalise=False), Shape(mesh)
    size = np.sqrt(mesh.area)
    assert plain.unit == 1.0
    assert unit.unit == pytest.approx(size)
    np.testing.assert_allclose(
        plain.metric("geodesic").between(POINTS),
        size * unit.metric("geodesic").between(POINTS),
        rtol=1e-9,
    )
    np.testing.assert_allclose(
        plain.spectrum().eigenvalues, unit.spectrum().eigenvalues / mesh.area, rtol=1e-9, atol=1e-12
    )
    np.testing.assert_allclose(
        plain.metric(Diffusion(0.02 * mesh.area)).between(POINTS) * size,
        unit.metric(Diffusion(0.02)).between(POINTS),
        rtol=1e-9,
    )
    # Table 1: what changes with scale and what does not.
    np.testing.assert_allclose(
        plain.metric("commute_time").between(POINTS),
        unit.metric("commute_time").between(POINTS),
        rtol=1e-9,
    )
    np.testing.assert_allclose(plain.descriptor("si_hks"), unit.descriptor("si_hks"), rtol=1e-9)
    hks = HeatKernelSignature().settled()
    assert np.abs(plain.descriptor(hks) - unit.descriptor(hks)).max() > 0.1
    # What is left out suits the shape's own size.
    np.testing.assert_allclose(plain.descriptor("hks"), unit.descriptor(hks), rtol=1e-9)
    assert plain.metric("diffusion") is plain.metric(Diffusion(0.01 * size**2))


@pytest.mark.parametrize("name", DESCRIPTORS)
def test_descriptors_at_some_vertices_are_those_at_all(name: str) -> None:
    shape, some = Shape(shapes.painted(shapes.cube())), np.array([3, 1, 40])
    np.testing.assert_allclose(
        shape.descriptor(name, some), shape.descriptor(name)[some], rtol=1e-9
    )


def test_everything_is_computed_once() -> None:
    shape = Shape(shapes.cube())
    for metric in METRICS:
        assert shape.metric(metric) is shape.metric(metric)
    assert shape.metric(Diffusion(0.1)) is not shape.metric("diffusion")
    assert shape.metric(Diffusion(0.01)) is shape.metric("diffusion")
    assert np.shares_memory(shape.spectrum().eigenfunctions, shape.spectrum(5).eigenfunctions)


def test_a_known_spectrum_is_used_and_a_short_one_is_not() -> None:
    mesh = shapes.cube()
    unit = laplace_beltrami_spectrum(mesh.scaled(1.0 / np.sqrt(mesh.area)), 30)
    shape = Shape(mesh, unit, eigenpairs=20)
    assert np.shares_memory(shape.spectrum().eigenvalues, unit.eigenvalues)
    assert shape.spectrum().n_eigenpairs == 20
    assert Shape(mesh, unit, eigenpairs=40).spectrum().n_eigenpairs == 40
    assert Shape(shapes.tetrahedron()).spectrum().n_eigenpairs == 4
    with pytest.raises(ValueError, match="another mesh"):
        Shape(shapes.tetrahedron(), unit)


def test_samplings_are_prefixes_of_the_longest() -> None:
    shape = Shape(shapes.blob())
    short = shape.sampling("geodesic", 5)
    long = shape.sampling("geodesic", 30)
    np.testing.assert_array_equal(long.indices[:5], short.indices)
    again = shape.sampling("geodesic", 12)
    assert np.shares_memory(again.indices, long.indices)
    assert not np.array_equal(
        shape.sampling(Diffusion(0.5), 30).indices, shape.sampling(Diffusion(0.001), 30).indices
    )


def test_no_descriptor_has_no_components() -> None:
    shape = Shape(shapes.cube(2))
    assert shape.descriptor("none").shape == (26, 0)
    assert shape.descriptor("none", np.array([3, 1])).shape == (2, 0)


@pytest.mark.parametrize("method", GEODESIC_METHODS)
def test_geodesics_by_the_method_chosen(method: str) -> None:
    mesh, points = shapes.blob(), np.arange(0, 600, 50)
    shape = Shape(mesh, geodesic_method=method)
    expected = GeodesicMetric(geodesics(shape.surface, method)).between(points)
    np.testing.assert_array_equal(shape.metric("geodesic").between(points), expected)


def test_unknown_names_and_bad_options() -> None:
    shape = Shape(shapes.cube(2))
    calls: list[tuple[str, Callable[[], object]]] = [
        ("metric", lambda: shape.metric("euclidean")),
        ("metric", lambda: shape.sampling("euclidean", 3)),
        ("descriptor", lambda: shape.descriptor("shot")),
        ("time", lambda: shape.metric(Diffusion(-1.0))),
        ("points", lambda: shape.sampling("geodesic", 1000)),
        ("eigenpairs", lambda: Shape(shapes.cube(2), eigenpairs=1)),
        ("geodesic_method", lambda: Shape(shapes.cube(2), geodesic_method="shortest")),
    ]
    for field, call in calls:
        with pytest.raises(OptionError) as caught:
            call()
        assert caught.value.field == field


def test_several_components_are_one_shape_until_one_is_chosen() -> None:
    both = shapes.two_components()
    assert np.isfinite(Shape(both).metric("geodesic").distances(np.array([0]))).all()
    assert Shape(largest_component(both)).n_vertices == shapes.icosphere(2).n_vertices
