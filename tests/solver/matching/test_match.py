"""Matches of shapes whose correspondence is known."""

from dataclasses import replace

import numpy as np
import pytest

from solver.control import Control
from solver.errors import Cancelled, OptionError
from solver.labelling import Method
from solver.matching import Match, MatchOptions, match
from solver.mesh import triangle_mesh
from solver.shape import Shape
from solver.shape.choices import CommuteTime, Diffusion
from synthetic import ASYMMETRIC_HUMAN, SyntheticShape, correspondence, human
from tests.solver import shapes


def shape_of(figure: SyntheticShape) -> Shape:
    return Shape(triangle_mesh(figure.vertices, figure.faces))


@pytest.fixture(scope="module")
def standing() -> SyntheticShape:
    return human("standing", ASYMMETRIC_HUMAN, resolution=900, seed=1)


@pytest.fixture(scope="module")
def sitting() -> SyntheticShape:
    return human("sitting", ASYMMETRIC_HUMAN, resolution=1100, seed=2)


@pytest.fixture(scope="module")
def answer(standing: SyntheticShape, sitting: SyntheticShape) -> Match:
    return match(shape_of(standing), shape_of(sitting), MatchOptions(points=32))


def test_poses_of_a_figure_are_matched(
    standing: SyntheticShape, sitting: SyntheticShape, answer: Match
) -> None:
    """Another pose, another triangulation, 32 points: the mean error is that of sampling."""
    truth = correspondence(standing, sitting)[answer.best.source]
    distances = shape_of(sitting).metric("geodesic").distances(answer.best.target)
    errors = distances[np.arange(32), truth]
    assert errors.mean() < 0.07
    assert errors.max() < 0.25
    assert len(np.unique(answer.best.target)) == 32


def test_the_certificate_holds_together(answer: Match) -> None:
    assert [level.points for level in answer.levels] == [8, 8, 16, 32]
    for level in answer.levels:
        assert 0.0 <= level.lower_bound <= level.energy
        assert level.gap == pytest.approx(1.0 - level.lower_bound / level.energy, abs=1e-12)
    coarse = answer.levels[0]
    assert coarse.method is Method.BRANCH_AND_BOUND
    assert coarse.certified
    assert answer.lower_bound == answer.levels[-1].lower_bound
    assert answer.gap < 0.05


def test_costs_sum_up_to_the_energy(answer: Match) -> None:
    """Alternatives come by their energy; the answer is chosen by registration."""
    for found in (answer.best, *answer.alternatives):
        assert found.costs.sum() == pytest.approx(found.energy)
    energies = [found.energy for found in answer.alternatives]
    assert energies == sorted(energies)


def test_alternatives_differ_from_the_answer_and_each_other(answer: Match) -> None:
    targets = {tuple(found.target) for found in (answer.best, *answer.alternatives)}
    assert len(targets) == 1 + len(answer.alternatives)


def test_confidence_is_a_probability_with_reasons(answer: Match) -> None:
    found = answer.confidence
    assert found is not None
    assert 0.5 < found.probability <= 1.0
    assert bool(found.reasons) == (found.probability < 0.9)
    assert {"score", "margin"} <= set(found.measures)


@pytest.mark.parametrize(
    "options",
    [
        MatchOptions(points=24),
        MatchOptions(points=10, metric=("geodesic",), descriptor=("none",)),
        MatchOptions(points=20, metric=(Diffusion(0.05),), descriptor=("hks",)),
    ],
)
def test_a_shape_matches_itself_perfectly(options: MatchOptions) -> None:
    shape = Shape(shapes.blob())
    found = match(shape, shape, options)
    assert found.best.energy == pytest.approx(0.0, abs=1e-12)
    assert (found.best.source == found.best.target).all()
    assert found.best.distortion.linf == pytest.approx(0.0, abs=1e-9)
    assert found.certified


def test_motion_scale_and_numbering_do_not_matter() -> None:
    mesh = shapes.blob()
    rng = np.random.default_rng(0)
    order = rng.permutation(mesh.n_vertices)
    place = np.argsort(order)
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    moved = triangle_mesh(
        7.0 * mesh.vertices[order] @ rotation * np.linalg.det(rotation) + 100.0, place[mesh.faces]
    )
    found = match(Shape(mesh), Shape(moved), MatchOptions(points=24))
    assert found.best.energy == pytest.approx(0.0, abs=1e-6)
    assert (order[found.best.target] == found.best.source).all()


def test_vertex_numbers_are_the_users_own() -> None:
    mesh = shapes.blob()
    stray = np.array([[50.0, 50.0, 50.0]])
    padded = triangle_mesh(np.concatenate([stray, mesh.vertices]), mesh.faces + 1)
    found = match(Shape(mesh), Shape(padded), MatchOptions(points=8))
    assert (found.best.target == found.best.source + 1).all()
    assert any("target" in warning for warning in found.warnings)


def test_occlusion_leaves_points_unmatched_and_pays_for_them(
    standing: SyntheticShape, sitting: SyntheticShape
) -> None:
    gamma = 0.01
    found = match(
        shape_of(standing), shape_of(sitting), MatchOptions(points=16, occlusion_cost=gamma)
    )
    lost = len(found.best.unmatched)
    assert 0 < lost < 16
    assert len(found.best.source) == 16 - lost
    assert found.best.energy == pytest.approx(found.best.costs.sum() + gamma * lost)
    assert found.best.energy <= 16 * gamma
    assert not set(found.best.unmatched) & set(found.best.source)


def test_occlusion_may_be_so_cheap_that_nothing_is_matched(
    standing: SyntheticShape, sitting: SyntheticShape
) -> None:
    options = MatchOptions(points=32, occlusion_cost=1e-12)
    found = match(shape_of(standing), shape_of(sitting), options)
    assert len(found.best.source) == 0
    assert len(found.best.unmatched) == 32
    assert found.best.energy == pytest.approx(32e-12)
    assert any(one.startswith("no point is matched") for one in found.warnings)
    assert found.certified


def test_a_metric_that_vanishes_is_refused() -> None:
    shape = Shape(shapes.icosphere(1))
    for metric in (Diffusion(1e6),), ("geodesic", Diffusion(1e6)):
        with pytest.raises(OptionError) as caught:
            match(shape, shape, MatchOptions(points=16, metric=metric))
        assert caught.value.field == f"metric.{len(metric) - 1}.time"


def test_a_match_is_deterministic(
    standing: SyntheticShape, sitting: SyntheticShape, answer: Match
) -> None:
    again = match(shape_of(standing), shape_of(sitting), MatchOptions(points=32))
    assert (again.best.target == answer.best.target).all()
    assert again.best.energy == answer.best.energy
    assert again.lower_bound == answer.lower_bound


def test_a_small_mesh_gives_what_it_has_and_says_so() -> None:
    shape = Shape(shapes.icosphere(1))
    found = match(shape, shape, MatchOptions(points=64))
    assert len(found.best.source) == 42
    assert any("42" in warning for warning in found.warnings)


def test_progress_rises_and_cancellation_leaves() -> None:
    shape = Shape(shapes.blob())
    reported: list[float] = []
    control = Control(on_progress=lambda stage, fraction: reported.append(fraction))
    match(shape, shape, MatchOptions(points=32, dense=True, refine="gmds"), control)
    assert reported == sorted(reported)
    assert 0.0 <= reported[0] < reported[-1] <= 1.0
    with pytest.raises(Cancelled):
        match(shape, shape, control=Control(is_cancelled=lambda: True))


def test_a_match_without_time_has_an_answer(
    standing: SyntheticShape, sitting: SyntheticShape
) -> None:
    shapes_asked = shape_of(standing), shape_of(sitting)
    found = match(*shapes_asked, MatchOptions(points=16, time_limit=1e-9))
    assert len(found.best.source) == 16
    assert found.lower_bound <= found.best.energy
    assert not found.certified
    assert any("time limit was reached" in one for one in found.warnings)
    assert not match(*shapes_asked, MatchOptions(points=6, time_limit=600.0)).warnings
    assert any(
        "time limit" in one for one in match(*shapes_asked, control=Control(deadline=0.0)).warnings
    )


def test_least_greatest_distortion(standing: SyntheticShape, sitting: SyntheticShape) -> None:
    source, target = shape_of(standing), shape_of(sitting)
    found = match(source, target, MatchOptions(points=8, objective="linf"))
    other = match(source, target, MatchOptions(points=8, metric=("commute_time",)))
    assert found.certified
    assert found.best.energy == found.best.distortion.linf == found.best.costs.max()
    assert found.best.energy <= other.best.distortion.linf
    assert all(another.energy == found.best.energy for another in found.alternatives)
    assert [level.points for level in found.levels] == [8]
    assert found.levels[0].method == "minimax"


def test_gromov_hausdorff_distance_of_the_samples(
    standing: SyntheticShape, sitting: SyntheticShape
) -> None:
    source, target = shape_of(standing), shape_of(sitting)
    options = MatchOptions(points=12, objective="linf", metric=("geodesic",))
    found, back = match(source, target, options), match(target, source, options)
    one, other = found.gromov_hausdorff_distance, back.gromov_hausdorff_distance
    assert one is not None
    assert other is not None
    assert one.certified
    assert one.points == 12
    assert one.value == other.value == one.costs.max() / 2
    first, second = (shape.sampling("geodesic", 12) for shape in (source, target))
    assert set(one.source) == set(source.mesh.vertex_ids[first.indices])
    assert set(one.target) == set(target.mesh.vertex_ids[second.indices])
    assert one.sampling_error == first.radii[-1] + second.radii[-1]
    assert one.value >= abs(first.distances.max() - second.distances.max()) / 2
    same = match(source, source, options).gromov_hausdorff_distance
    assert same is not None
    assert same.value == 0.0


def test_bounds_of_more_points_than_can_be_proven(
    standing: SyntheticShape, sitting: SyntheticShape
) -> None:
    options = MatchOptions(points=32, objective="linf", proof_work=0.01)
    found = match(shape_of(standing), shape_of(sitting), options)
    distance = found.gromov_hausdorff_distance
    assert distance is not None
    assert 0.0 <= distance.lower_bound < distance.value
    assert found.lower_bound <= found.best.energy == found.best.distortion.linf
    assert not distance.certified
    assert any("Gromov-Hausdorff distance" in warning for warning in found.warnings)
    without = match(shape_of(standing), shape_of(sitting), replace(options, proof="candidates"))
    assert without.gromov_hausdorff_distance is None


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("points", 2),
        ("points", 257),
        ("coarse_points", 11),
        ("level_factor", 1),
        ("oversampling", 9),
        ("rho", 0.5),
        ("beta", -1.0),
        ("beta", float("nan")),
        ("first_order_weight", float("inf")),
        ("alternatives", 0),
        ("metric.0", ("euclidean",)),
        ("metric.1", ("geodesic", 3)),
        ("metric", ()),
        ("metric", CommuteTime()),
        ("descriptor", "none"),
        ("descriptor.0", ("shot",)),
        ("occlusion_cost", 0.0),
        ("time_limit", -1.0),
        ("objective", "l1"),
    ],
)
def test_options_out_of_range_name_their_field(field: str, value: object) -> None:
    with pytest.raises(OptionError) as caught:
        MatchOptions(**{field.split(".")[0]: value})  # type: ignore[arg-type]
    assert caught.value.field == field
