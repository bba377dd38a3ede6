"""Damaged meshes: repaired so that no answer shows it, or told of, or refused with the reason."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh, largest_component, triangle_mesh
from solver.shape import Shape
from tests.solver import shapes
from tests.solver.mesh.repair.damage import (
    DISTORTING,
    HARMLESS,
    REFUSED,
    Damage,
    degenerate,
    name_of,
    read,
)

PROBES = np.arange(0, 642, 13)
RETRIANGULATED = {
    degenerate.caps,
    degenerate.t_junction,
    degenerate.t_junctions_on_both_sides,
    degenerate.t_junctions_and_seams,
}
"""The same surface, but with vertices more: discrete operators differ by their own error."""


@dataclass(frozen=True, eq=False)
class Answers:
    """What is computed on a shape, at probes and between them."""

    eigenvalues: FloatArray
    geodesics: FloatArray
    commute_times: FloatArray
    signatures: FloatArray
    matched: list[tuple[int, int]]


def answers(mesh: TriangleMesh, probes: IntArray) -> Answers:
    shape = Shape(mesh, eigenpairs=30)
    found = match(shape, partner(), MatchOptions(points=8, orientation=False)).best
    return Answers(
        shape.spectrum().eigenvalues,
        shape.metric("geodesic").between(probes),
        shape.metric("commute_time").between(probes),
        shape.descriptor("hks", probes),
        list(zip(found.source.tolist(), found.target.tolist(), strict=True)),
    )


@cache
def partner() -> Shape:
    """The undamaged surface, turned and numbered otherwise."""
    return Shape(shapes.permuted(shapes.moved(shapes.blob(3), 5), 3)[0], eigenpairs=30)


@cache
def undamaged() -> Answers:
    return answers(shapes.blob(3), PROBES)


@pytest.mark.parametrize(("cause", "told"), HARMLESS.items(), ids=name_of)
def test_harmless_damage_is_repaired_and_no_answer_shows_it(cause: Damage, told: str) -> None:
    original, damaged = shapes.blob(3), cause(shapes.blob(3))
    mesh = read(damaged)
    assert any(told in warning for warning in mesh.warnings) if told else mesh.warnings == ()
    assert mesh.components == 1
    assert mesh.closed
    assert mesh.area / damaged.scale**2 == pytest.approx(original.area, rel=1e-6)
    assert enclosed_volume(mesh) > 0.0
    probes = mesh.vertices_of(damaged.where[PROBES])
    np.testing.assert_allclose(
        mesh.vertices[probes], damaged.vertices[damaged.where[PROBES]], atol=1e-5 * damaged.scale
    )
    expected, found = undamaged(), answers(mesh, probes)
    error = 5e-3 if cause in RETRIANGULATED else 2e-5
    for field in ("eigenvalues", "geodesics", "commute_times", "signatures"):
        truth = getattr(expected, field)
        np.testing.assert_allclose(
            getattr(found, field), truth, atol=error * float(truth.max()), err_msg=field
        )
    numbers = {int(number): vertex for vertex, number in enumerate(damaged.where)}
    assert [(numbers[source], target) for source, target in found.matched] == expected.matched


def enclosed_volume(mesh: TriangleMesh) -> float:
    unit = mesh.scaled(1.0 / np.sqrt(mesh.area))
    a, b, c = (unit.vertices[unit.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


@pytest.mark.parametrize(("cause", "told"), DISTORTING.items(), ids=name_of)
def test_damage_that_cannot_be_undone_is_told_of(cause: Damage, told: str) -> None:
    mesh = read(cause(shapes.blob(3)))
    assert [warning for warning in mesh.warnings if told in warning]
    assert_sound(mesh)


@pytest.mark.parametrize(("cause", "reason"), REFUSED.items(), ids=name_of)
def test_what_is_no_surface_is_refused_with_the_reason(cause: Damage, reason: str) -> None:
    with pytest.raises(MeshError, match=reason):
        read(cause(shapes.blob(3)))


def test_a_surface_and_its_repair_is_the_same_again() -> None:
    for cause in HARMLESS:
        mesh = read(cause(shapes.blob(3)))
        again = triangle_mesh(mesh.vertices, mesh.faces)
        assert again.warnings == (), cause.__name__
        np.testing.assert_array_equal(again.faces, mesh.faces)


# --- anything at all ------------------------------------------------------------------------------


def assert_sound(mesh: TriangleMesh) -> None:
    """Whatever is computed on its largest component is finite, or refused."""
    assert 0.0 < mesh.area < np.inf
    assert (np.sort(mesh.faces, axis=1)[:, 1:] > np.sort(mesh.faces, axis=1)[:, :-1]).all()
    np.testing.assert_array_equal(np.unique(mesh.faces), np.arange(mesh.n_vertices))
    shape = Shape(largest_component(mesh), eigenpairs=20)
    spectrum = shape.spectrum()
    assert np.isfinite(spectrum.eigenvalues).all()
    assert (spectrum.eigenvalues >= 0.0).all()
    products = spectrum.eigenfunctions.T @ (spectrum.mass[:, None] * spectrum.eigenfunctions)
    np.testing.assert_allclose(products, np.eye(spectrum.n_eigenpairs), atol=1e-6)
    everywhere = np.arange(shape.n_vertices)
    for metric in ("geodesic", "diffusion", "commute_time"):
        assert np.isfinite(shape.metric(metric).between(everywhere)).all()
    for descriptor in ("hks", "si_hks"):
        assert np.isfinite(shape.descriptor(descriptor)).all()


@st.composite
def soups(draw: st.DrawFn) -> tuple[FloatArray, IntArray]:
    """Random triangles: in general position, on a grid, flattened, repeated, of any size."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, m = draw(st.integers(3, 40)), draw(st.integers(1, 90))
    vertices = random.standard_normal((n, 3))
    if draw(st.booleans()):
        vertices = np.round(vertices, draw(st.integers(0, 2)))
    if draw(st.booleans()):
        vertices[:, 2] *= 10.0 ** draw(st.integers(-20, 0))
    if draw(st.booleans()):
        copies = random.integers(0, n, (2, n // 2))
        noise = 10.0 ** draw(st.integers(-17, -2)) * random.standard_normal((n // 2, 3))
        vertices[copies[0]] = vertices[copies[1]] + noise
    vertices *= 10.0 ** draw(st.integers(-70, 70))
    return vertices, random.integers(0, n, (m, 3))


@settings(max_examples=120)
@given(soups())
def test_whatever_is_read_gives_finite_answers(soup: tuple[FloatArray, IntArray]) -> None:
    try:
        mesh = triangle_mesh(*soup)
    except MeshError:
        return
    assert_sound(mesh)
