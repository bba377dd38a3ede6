"""Prototypes: learned from examples, stored, and matched."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.arrays import IntArray
from solver.errors import OptionError, PrototypeError
from solver.labelling import UNMATCHED, LabellingProblem
from solver.matching import MatchOptions, SampledStructure, refine
from solver.mesh import triangle_mesh
from solver.optimisation import minimise
from solver.optimisation.exact import m_best_solutions
from solver.optimisation.primal import local_search
from solver.prototype import (
    CorrespondingExamples,
    Example,
    LearnedDescriptors,
    LearnedDistances,
    Prototype,
    PrototypeOptions,
    all_pairs,
    connected_examples,
    given_examples,
    learn_prototype,
    match_prototype,
    matched_examples,
    prototype_from_bytes,
    prototype_to_bytes,
)
from solver.prototype.learning import discriminant_axes
from solver.prototype.matching import PrototypeLevel, mean_distances
from solver.prototype.mixtures import GaussianMixtures
from solver.shape import Shape
from solver.shape.choices import (
    Diffusion,
    Geodesic,
    MetricChoice,
    ScaleInvariantHeatKernelSignature,
)
from synthetic import HUMAN_POSES, human
from tests.solver import shapes

_RESOLUTION = 500
_SMALL = PrototypeOptions(points=8, components=2)
_PLAIN = MatchOptions(points=8, orientation=False)


@cache
def humans() -> tuple[Shape, ...]:
    """One body in several poses, triangulated alike."""
    figures = [human(pose, resolution=_RESOLUTION) for pose in HUMAN_POSES]
    return tuple(Shape(triangle_mesh(one.vertices, one.faces)) for one in figures)


@cache
def prototype() -> Prototype:
    return learn_prototype(connected_examples(humans(), _SMALL).examples, _SMALL)


def tiny_level(seed: int, n: int, m: int, gamma: float) -> PrototypeLevel:
    """A level of random mixtures and random distances."""
    rng = np.random.default_rng(seed)
    pairs = n * (n - 1) // 2
    distances = GaussianMixtures(
        rng.dirichlet(np.ones(2), pairs),
        rng.uniform(0.0, 2.0, (pairs, 2, 1)),
        rng.uniform(0.01, 0.3, (pairs, 2, 1, 1)),
    )
    descriptors = GaussianMixtures(
        rng.dirichlet(np.ones(2), n),
        rng.normal(size=(n, 2, 2)),
        rng.uniform(0.1, 1.0, (n, 2, 1, 1)) * np.eye(2),
    )
    between = np.abs(rng.normal(size=(m, m)))
    target = SampledStructure(np.arange(m), between + between.T, rng.normal(size=(m, 2)))
    np.fill_diagonal(target.distances, 0.0)
    source = SampledStructure(np.arange(n), mean_distances(distances, n), None)
    return PrototypeLevel(
        0,
        Geodesic(),
        ScaleInvariantHeatKernelSignature(),
        source,
        target,
        1.0,
        0.3,
        gamma,
        LearnedDistances(Geodesic(), distances, -20.0),
        LearnedDescriptors(
            ScaleInvariantHeatKernelSignature(), np.zeros(2), np.eye(2), descriptors, -20.0
        ),
    )


def all_correspondences(problem: LabellingProblem) -> list[IntArray]:
    n, m = problem.shape
    pool = [*range(m), *([] if problem.must_match_all else [UNMATCHED] * n)]
    return [np.array(chosen) for chosen in set(permutations(pool, n))]


@settings(max_examples=15)
@given(seed=st.integers(0, 2**16), gamma=st.sampled_from([np.inf, 0.5, 3.0]))
def test_bound_optimum_and_energy_are_in_order(seed: int, gamma: float) -> None:
    level = tiny_level(seed, 3, 4, gamma)
    problem = level.problem(level.all_candidates())
    assert problem.non_negative
    energies = {tuple(one): problem.energy(one) for one in all_correspondences(problem)}
    optimum = min(energies.values())
    found = minimise(problem)
    assert found.lower_bound <= optimum + 1e-9
    assert found.value == pytest.approx(optimum)
    best = m_best_solutions(problem, 5)
    np.testing.assert_allclose(best.energies, sorted(energies.values())[:5], atol=1e-9)
    start = np.array(next(iter(energies)))
    assert problem.energy(local_search(problem, start)) <= energies[tuple(start)] + 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_problems_of_a_level_do_not_depend_on_earlier_ones(seed: int) -> None:
    rng = np.random.default_rng(seed)
    level = tiny_level(seed, 4, 6, np.inf)
    everything = level.all_candidates()
    for share in (0.5, 0.6, 0.0, 0.7, 1.0):
        candidates = everything[rng.random(len(everything)) < share]
        problem = level.problem(candidates)
        assert level.problem(candidates.copy()) is problem
        alone = tiny_level(seed, 4, 6, np.inf).problem(candidates)
        np.testing.assert_array_equal(problem.candidates, candidates)
        np.testing.assert_array_equal(problem.unary, alone.unary)
        np.testing.assert_array_equal(problem.table, alone.table)


def test_peaks_are_computed_for_the_points_of_a_level_alone() -> None:
    """A prototype of 256 points has 32,640 distributions of distances, its coarsest level 45."""
    level = tiny_level(0, 6, 7, np.inf)
    few = np.arange(4)
    coarse = replace(level, source=SampledStructure(few, level.source.distances[:4, :4], None))
    problem = coarse.problem(coarse.all_candidates())
    assert level.learned_descriptors is not None
    for mixtures in (level.learned_distances.mixtures, level.learned_descriptors.mixtures):
        assert "log_peaks" not in vars(mixtures)
    both = level.problem(level.all_candidates())
    np.testing.assert_allclose(problem.unary, both.unary[: 4 * 7])
    # A pair weighs 2/(N - 1).
    np.testing.assert_allclose(3.0 * problem.table, 5.0 * both.table[: 4 * 7, : 4 * 7])


@pytest.mark.parametrize("n", [18])
def test_dual_decomposition_bounds_tabulated_costs(n: int) -> None:
    level = tiny_level(1, n, n, np.inf)
    candidates = level.all_candidates()
    near = np.abs(candidates[:, 0] - candidates[:, 1]) <= 1
    problem = level.problem(candidates[near])
    found = minimise(problem, iterations=300)
    exact = m_best_solutions(problem)
    assert exact.proven
    assert found.lower_bound <= exact.energies[0] + 1e-9 <= found.value + 2e-9


def test_energies_are_log_likelihoods_up_to_a_constant() -> None:
    level = tiny_level(0, 4, 6, np.inf)
    problem = level.problem(level.all_candidates())
    one, two = np.array([0, 1, 2, 3]), np.array([5, 3, 0, 1])

    def likelihood(partners: IntArray) -> float:
        learned = level.learned_distances
        i, j = all_pairs(4)
        between = level.target.distances[partners[i], partners[j]]
        pairs = learned.mixtures.log_density(between[:, None, None])[:, 0]
        points = level.learned_descriptors
        assert points is not None
        assert level.target.descriptors is not None
        fields = points.mixtures.log_density(level.target.descriptors[partners][:, None])[:, 0]
        background = learned.log_background
        pairwise = np.logaddexp(pairs, background).sum() * 2.0 / 3.0
        unary = 0.3 * np.logaddexp(fields, background).sum()
        return float(pairwise + unary)

    difference = problem.energy(one) - problem.energy(two)
    assert difference == pytest.approx(likelihood(two) - likelihood(one), abs=1e-6)


def test_a_table_is_the_same_as_terms_of_all_pairs() -> None:
    level = tiny_level(2, 4, 6, 2.0)
    problem = level.problem(level.all_candidates())
    partners = np.array([2, UNMATCHED, 5, 0])
    chosen = problem.chosen_candidates(partners)
    used = chosen[chosen >= 0]
    expected = problem.unary[used].sum() + problem.table[np.ix_(used, used)].sum() / 2.0 + 2.0
    assert problem.energy(partners) == pytest.approx(expected)
    with pytest.raises(ValueError, match="every two"):
        replace(problem, table=np.zeros((2, 2)))
    with pytest.raises(ValueError, match="finite"):
        replace(problem, table=np.full_like(problem.table, np.nan))


def test_pairs_of_the_first_points_come_first() -> None:
    first, second = all_pairs(6)
    assert (second * (second - 1) // 2 + first).tolist() == list(range(15))
    assert second[:10].max() == 4


def test_discriminant_axes_separate_points_despite_class_variation() -> None:
    rng = np.random.default_rng(0)
    samples = rng.normal(size=(5, 200, 3)) * np.array([10.0, 0.1, 1.0])
    samples[:, :, 1] += np.arange(5)[:, None]
    axes = discriminant_axes(samples, 1)
    assert abs(axes[1, 0]) > 20.0 * np.abs(axes[[0, 2], 0]).max()
    assert discriminant_axes(np.ones((4, 3, 2)), 2).shape == (2, 0)
    noise = rng.choice([-1e-16, 0.0, 1e-16], (12, 6, 3))
    assert discriminant_axes(0.3 + noise, 4).shape == (3, 0)


def test_a_prototype_finds_its_own_points_on_an_example() -> None:
    answer = match_prototype(prototype(), humans()[1], _PLAIN)
    assert answer.best.source.tolist() == list(range(8))
    assert answer.certified
    assert 0.0 <= answer.lower_bound <= answer.best.energy
    energies = [answer.best.energy, *(one.energy for one in answer.alternatives)]
    assert energies == sorted(energies)
    hurried = match_prototype(prototype(), humans()[1], replace(_PLAIN, time_limit=1e-9))
    assert any("time limit was reached" in one for one in hurried.warnings)
    assert not any("time limit" in one for one in answer.warnings)


@pytest.mark.parametrize("oversampling", [1, 4, 7])
def test_a_target_is_sampled_as_densely_as_asked(oversampling: int) -> None:
    options = replace(_PLAIN, oversampling=oversampling)
    answer = match_prototype(prototype(), humans()[1], options)
    assert [level.target_points for level in answer.levels] == [8 * oversampling]


def test_a_prototype_of_more_points_is_matched_by_levels() -> None:
    options = PrototypeOptions(points=14, components=1)
    learned = learn_prototype(connected_examples(humans(), options).examples, options)
    answer = match_prototype(learned, humans()[2], replace(_PLAIN, points=14))
    assert [level.points for level in answer.levels] == [10, 14]
    asked = match_prototype(learned, humans()[2], replace(_PLAIN, points=14, coarse_points=8))
    assert [level.points for level in asked.levels] == [8, 14]
    assert sorted(answer.best.source.tolist()) == list(range(14))
    assert answer.lower_bound <= answer.best.energy


def test_points_beyond_those_of_the_prototype_are_warned_of() -> None:
    answer = match_prototype(prototype(), humans()[1], replace(_PLAIN, points=32))
    assert len(answer.best.source) == 8
    assert "32 points were asked for: the prototype has 8" in answer.warnings


def test_with_little_occlusion_cost_unlikely_points_stay_unmatched() -> None:
    answer = match_prototype(prototype(), humans()[1], replace(_PLAIN, occlusion_cost=1e-6))
    assert len(answer.best.unmatched) == 8


def test_points_all_unmatched_stay_so_at_finer_levels() -> None:
    coarse = np.full(4, UNMATCHED)
    found = refine(coarse, tiny_level(0, 6, 8, 1e-6), rho=1.5)
    assert (found.partners == UNMATCHED).all()
    assert found.energy == pytest.approx(6e-6)


def test_prototypes_of_one_example_and_of_any_order() -> None:
    alone = learn_prototype(connected_examples(humans()[:1], _SMALL).examples, _SMALL)
    answer = match_prototype(alone, humans()[0], _PLAIN)
    assert answer.best.energy < 1.0
    examples = connected_examples(humans(), _SMALL).examples
    turned = learn_prototype((examples[0], *examples[:0:-1]), _SMALL)
    between = np.full((28, 1, 1), 0.7)
    np.testing.assert_allclose(
        turned.distances[0].mixtures.log_density(between),
        prototype().distances[0].mixtures.log_density(between),
        rtol=1e-6,
    )


def test_given_correspondences_are_those_of_shared_connectivity() -> None:
    every = np.arange(humans()[0].n_vertices)
    ours = given_examples(humans(), [every] * len(humans()), _SMALL, reference=1)
    assert ours.kept[0] == 1
    for example in ours.examples:
        np.testing.assert_array_equal(example.vertices, ours.examples[0].vertices)
    with pytest.raises(OptionError, match="as long"):
        given_examples(humans()[:2], [every, every[:9]], _SMALL)
    with pytest.raises(OptionError, match="not on the shape"):
        given_examples(humans()[:2], [every, every + 1], _SMALL)


def test_given_vertices_may_have_been_merged_by_repair() -> None:
    """A seam: two vertices of the file are one of the surface, and either names it."""
    mesh = shapes.blob(1)
    seam = mesh.n_vertices
    faces = mesh.faces.copy()
    row, corner = np.argwhere(faces == 0)[0]
    faces[row, corner] = seam
    seamed = Shape(triangle_mesh(np.concatenate([mesh.vertices, mesh.vertices[:1]]), faces))
    options = PrototypeOptions(points=8, components=1)
    every = np.arange(mesh.n_vertices)
    other_name = np.where(every == 0, seam, every)
    one, two = (given_examples([seamed], [ids], options).examples[0] for ids in (every, other_name))
    np.testing.assert_array_equal(one.vertices, two.vertices)
    few = np.array([0, seam, 1, 2, 3, 4, 5, 6])
    with pytest.raises(OptionError, match="only 7 of its vertices"):
        given_examples([seamed], [few], options)


@pytest.mark.parametrize("examples_of", [matched_examples, connected_examples])
def test_shapes_of_fewer_vertices_than_points_are_refused(
    examples_of: Callable[[list[Shape], PrototypeOptions], CorrespondingExamples],
) -> None:
    """As those are that were simplified too much."""
    large, small = Shape(shapes.blob(2)), Shape(shapes.blob(1))
    with pytest.raises(OptionError, match="has 42 vertices, fewer than 64 points") as caught:
        examples_of([large, small], PrototypeOptions(points=64))
    assert caught.value.field == "shapes.1"


def test_shapes_without_shared_connectivity_are_refused() -> None:
    other = human("walking", resolution=_RESOLUTION, seed=1)
    stranger = Shape(triangle_mesh(other.vertices, other.faces))
    with pytest.raises(OptionError, match="triangles") as caught:
        connected_examples([humans()[0], stranger], _SMALL)
    assert caught.value.field == "shapes.1"


def test_matches_put_examples_into_correspondence_without_mixing_mirror_images() -> None:
    found = matched_examples(humans()[:3], _SMALL)
    assert found.kept[0] == 0
    own = found.examples[0].vertices
    for example in found.examples:
        between = example.shape.metric("commute_time").between(example.vertices)
        reference = humans()[0].metric("commute_time").between(own)
        assert np.abs(between - reference).mean() < 0.1 * reference.max()


def test_an_archive_holds_all_of_a_prototype() -> None:
    data = prototype_to_bytes(prototype())
    again = prototype_from_bytes(data)
    assert prototype_to_bytes(again) == data
    one, two = (match_prototype(each, humans()[1], _PLAIN) for each in (prototype(), again))
    assert one.best.energy == two.best.energy


@settings(max_examples=40)
@given(st.data())
def test_damaged_archives_are_refused(data: st.DataObject) -> None:
    sound = prototype_to_bytes(prototype())
    place = data.draw(st.integers(0, len(sound) - 1))
    broken = data.draw(
        st.sampled_from(
            [sound[:place], sound[:place] + bytes([sound[place] ^ 255]) + sound[place + 1 :], b""]
        )
    )
    try:
        read = prototype_from_bytes(broken)
    except PrototypeError:
        return
    assert prototype_to_bytes(read) == sound  # a byte that says nothing


@pytest.mark.parametrize(
    ("options", "field"),
    [
        (MatchOptions(refine="gmds"), "refine"),
        (MatchOptions(objective="linf", points=8), "objective"),
        (MatchOptions(partial="source"), "partial"),
        (MatchOptions(partial="both"), "partial"),
        (MatchOptions(metric=("diffusion",)), "metric"),
        (MatchOptions(descriptor=("wks",)), "descriptor"),
    ],
)
def test_options_unsuited_to_a_prototype_are_refused(options: MatchOptions, field: str) -> None:
    with pytest.raises(OptionError) as caught:
        match_prototype(prototype(), humans()[0], options)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("metric", "descriptor"),
    [(("diffusion",), ("none",)), ((Diffusion(time=0.01), "geodesic"), ("none", "hks"))],
)
def test_a_prototype_is_matched_with_the_structures_it_was_learned_with(
    metric: tuple[MetricChoice | str, ...], descriptor: tuple[str, ...]
) -> None:
    options = PrototypeOptions(points=4, components=1, metric=metric, descriptor=descriptor)
    learned = learn_prototype(connected_examples(humans()[:2], options).examples, options)
    matching = replace(_PLAIN, points=4, metric=metric, descriptor=descriptor)
    (level,) = match_prototype(learned, humans()[2], matching).levels
    assert (level.metric, level.descriptor) == ("diffusion", "none")
    for other, field in (
        (replace(matching, metric=(Diffusion(time=0.02), *metric[1:])), "metric"),
        (replace(matching, metric=(*metric, "geodesic")), "metric"),
        (replace(matching, descriptor=("hks", *descriptor[1:])), "descriptor"),
    ):
        with pytest.raises(OptionError) as caught:
            match_prototype(learned, humans()[2], other)
        assert caught.value.field == field


def test_examples_that_do_not_correspond_are_refused() -> None:
    first, second = humans()[:2]
    with pytest.raises(PrototypeError, match="at least one"):
        learn_prototype([], _SMALL)
    few, more = Example(first, np.arange(4)), Example(second, np.arange(5))
    with pytest.raises(PrototypeError, match="has 5 points"):
        learn_prototype([few, more], _SMALL)
    other = Shape(second.mesh, eigenpairs=20)
    with pytest.raises(PrototypeError, match="other settings"):
        learn_prototype([few, Example(other, np.arange(4))], _SMALL)
