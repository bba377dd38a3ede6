"""Every structure: what scaling, motion and numbering do to it, and what a choice may be."""

from collections.abc import Callable

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.errors import OptionError
from solver.matching import MatchOptions, match
from solver.mesh import TriangleMesh
from solver.shape import Shape
from solver.shape.choices import (
    DESCRIPTORS,
    METRICS,
    DescriptorChoice,
    Diffusion,
    Eigenfunctions,
    GaussianCurvature,
    GeodesicHistogram,
    HeatKernelSignature,
    Photometric,
    ScaleInvariantHeatKernelSignature,
    Structure,
    WaveKernelSignature,
)
from solver.shape.laplacian import Spectrum
from tests.solver import shapes

STRUCTURES = [name for name in (*METRICS, *DESCRIPTORS) if name != "none"]

POWERS = {"diffusion": -1, "geodesic": 1, "biharmonic": 1, "gaussian_curvature": -2}
"""Powers of length that structures are measured in; those without unit are not here."""


def chosen(name: str) -> Structure:
    return (METRICS | DESCRIPTORS)[name]()


def values(shape: Shape, choice: Structure, points: IntArray) -> FloatArray:
    if choice.name in METRICS:
        return shape.metric(METRICS[choice.name](**vars(choice))).between(points)
    return shape.descriptor(DESCRIPTORS[choice.name](**vars(choice)), points)


def deviation(found: FloatArray, expected: FloatArray) -> float:
    return float(np.abs(found - expected).max() / np.abs(expected).max())


POINTS = np.arange(0, 642, 13)
SCALE = 37.0


@pytest.fixture(scope="module")
def original() -> TriangleMesh:
    return shapes.painted(shapes.blob())


@pytest.fixture(scope="module")
def unit(original: TriangleMesh) -> Shape:
    return Shape(original)


@pytest.fixture(scope="module")
def plain(original: TriangleMesh) -> tuple[Shape, Shape]:
    """The same in the user's units, and scaled."""
    larger = shapes.moved(original, seed=5, scale=SCALE)
    return Shape(original, normalise=False), Shape(larger, normalise=False)


@pytest.fixture(scope="module")
def renumbered(original: TriangleMesh) -> tuple[Shape, IntArray]:
    """Moved, scaled, its vertices in another order; vertex v is vertex ``where[v]`` there."""
    mesh, where = shapes.permuted(shapes.moved(original, seed=3, scale=1e7), seed=4)
    return Shape(mesh), where


@pytest.mark.parametrize("name", STRUCTURES)
def test_scaling_changes_units(name: str, plain: tuple[Shape, Shape]) -> None:
    """λ goes to λ/s² and φ to φ/s, so that a length**p goes to s**p, times and radii along."""
    shape, larger = plain
    here = values(shape, chosen(name).settled(shape.size), POINTS)
    there = values(larger, chosen(name).settled(larger.size), POINTS)
    assert larger.size == pytest.approx(SCALE * shape.size, rel=1e-12)
    assert deviation(there, SCALE ** POWERS.get(name, 0) * here) < 1e-6


@pytest.mark.parametrize("name", STRUCTURES)
def test_table_1_scale(name: str, plain: tuple[Shape, Shape]) -> None:
    """With the same parameters in the same unit, only what is invariant to scale stays."""
    shape, larger = plain
    choice = chosen(name).settled(shape.size)
    if isinstance(choice, Photometric):
        choice = Photometric(0.0)  # averages over a disc of the same size are of another part
    change = deviation(values(larger, choice, POINTS), values(shape, choice, POINTS))
    assert change < 1e-6 if chosen(name).invariance.scale == "yes" else change > 0.1


@pytest.mark.parametrize("name", STRUCTURES)
def test_motion_numbering_and_size_do_not_matter(
    name: str, unit: Shape, renumbered: tuple[Shape, IntArray]
) -> None:
    other, where = renumbered
    here = values(unit, chosen(name), POINTS)
    there = values(other, chosen(name), where[POINTS])
    assert deviation(there, here) < 1e-9


@pytest.mark.parametrize("name", DESCRIPTORS)
def test_a_shape_matches_itself_by_any_descriptor(
    name: str, unit: Shape, plain: tuple[Shape, Shape]
) -> None:
    options = MatchOptions(points=8, orientation=False, descriptor=(name,), first_order_weight=1.0)
    for shape in (unit, plain[1]):
        found = match(shape, shape, options)
        assert (found.best.source == found.best.target).all()
        assert found.best.energy == pytest.approx(0.0, abs=1e-9)
        assert found.levels[0].descriptor == name


@pytest.mark.parametrize("name", [name for name in DESCRIPTORS if name != "none"])
def test_a_descriptor_alone_finds_the_points(
    name: str, unit: Shape, renumbered: tuple[Shape, IntArray]
) -> None:
    """Without a second-order term each point goes where its descriptor says."""
    other, where = renumbered
    options = MatchOptions(
        points=8,
        descriptor=(name,),
        first_order_weight=1.0,
        beta=0.0,
        alternatives=1,
        orientation=False,
    )
    found = match(unit, other, options)
    assert (found.best.target == where[found.best.source]).all()


@pytest.mark.parametrize(
    ("metric", "descriptor", "sees"),
    [
        ("diffusion", "hks", True),
        ("geodesic", "geodesic_histogram", True),
        ("biharmonic", "gaussian_curvature", True),
        ("commute_time", "si_hks", False),
        ("commute_time", Photometric(0.0), False),
    ],
)
def test_differences_of_scale_count_when_shapes_are_not_normalised(
    metric: str, descriptor: DescriptorChoice | str, sees: bool, plain: tuple[Shape, Shape]
) -> None:
    """Figure 2, third row: parameters left out are the same for both, and so do not hide them."""
    options = MatchOptions(
        points=8,
        metric=(metric,),
        descriptor=(descriptor,),
        first_order_weight=1.0,
        orientation=False,
    )
    energy = match(*plain, options).best.energy
    assert energy > 0.1 if sees else energy < 1e-6


def test_signs_of_eigenfunctions_do_not_matter(unit: Shape, original: TriangleMesh) -> None:
    spectrum = unit.spectrum()
    flipped = spectrum.eigenfunctions * np.where(np.arange(100) % 2, -1.0, 1.0)
    unlike = Shape(original, Spectrum(spectrum.eigenvalues, flipped, spectrum.mass))
    options = MatchOptions(
        points=8, orientation=False, descriptor=(Eigenfunctions(12),), first_order_weight=1.0
    )
    found = match(unit, unlike, options)
    assert (found.best.source == found.best.target).all()
    assert found.best.energy < 1e-9


def test_colours_are_needed_where_they_are_compared(unit: Shape) -> None:
    bare, coloured = Shape(shapes.blob(), unit.spectrum()), unit
    options = MatchOptions(points=8, orientation=False, descriptor=("none", "photometric"))
    assert match(bare, bare, options).best.energy < 1e-9  # one level: nothing photometric
    for pair, name in (((bare, coloured), "source"), ((coloured, bare), "target")):
        with pytest.raises(OptionError, match=f"{name} has no vertex colours") as caught:
            match(
                *pair,
                MatchOptions(points=16, orientation=False, descriptor=("none", "photometric")),
            )
        assert caught.value.field == "descriptor.1"
    with pytest.raises(OptionError, match="no vertex colours"):
        bare.descriptor("photometric")
    unweighed = MatchOptions(
        points=8, orientation=False, descriptor=("photometric",), first_order_weight=0.0
    )
    assert match(bare, bare, unweighed).best.energy < 1e-9


def test_shapes_that_are_normalised_and_not_do_not_compare() -> None:
    mesh = shapes.cube(2)
    with pytest.raises(OptionError) as caught:
        match(Shape(mesh), Shape(mesh, normalise=False), MatchOptions(points=4))
    assert caught.value.field == "normalise"
    tiny = Shape(shapes.moved(mesh, seed=1, scale=1e-13), normalise=False)
    with pytest.raises(OptionError) as caught:
        match(tiny, tiny, MatchOptions(points=4))
    assert caught.value.field == "normalise"


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: Diffusion(0.0), "time"),
        (lambda: Diffusion(float("nan")), "time"),
        (lambda: Photometric(-1.0), "radius"),
        (lambda: GeodesicHistogram(radius=0.0), "radius"),
        (lambda: GeodesicHistogram(bins=0), "bins"),
        (lambda: GeodesicHistogram(bins=2.5), "bins"),  # type: ignore[arg-type]
        (lambda: GaussianCurvature(float("inf")), "scale"),
        (lambda: HeatKernelSignature(()), "times"),
        (lambda: HeatKernelSignature((0.1, -0.1)), "times"),
        (lambda: ScaleInvariantHeatKernelSignature(41), "frequencies"),
        (lambda: WaveKernelSignature(0.0), "sigma"),
        (lambda: Eigenfunctions(0), "count"),
    ],
)
def test_parameters_out_of_range(make: Callable[[], Structure], field: str) -> None:
    with pytest.raises(OptionError) as caught:
        make()
    assert caught.value.field == field


def test_choices_are_values() -> None:
    assert Diffusion(2) == Diffusion(np.float32(2.0))  # type: ignore[arg-type]
    assert hash(Diffusion(2)) == hash(Diffusion(2.0))
    times = HeatKernelSignature([1, 2])  # type: ignore[arg-type]
    assert times == HeatKernelSignature((1.0, 2.0))
    assert {times: "once"}[HeatKernelSignature((1.0, 2.0))] == "once"
    assert Diffusion().settled(10.0) == Diffusion(1.0)
    assert Diffusion(3.0).settled(10.0) == Diffusion(3.0)
    assert GeodesicHistogram().settled(2.0) == GeodesicHistogram(0.6, 8)
