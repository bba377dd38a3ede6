"""The third-order term of a match: its definition, its triples, and mirror images."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from solver.control import Control
from solver.errors import OptionError
from solver.labelling import LINF, NO_TRIPLES
from solver.matching import Hypothesis, Level, MatchOptions, match
from solver.matching.certification import prove_over_samples
from solver.matching.hierarchy import RefinedCorrespondence
from solver.matching.refinement import solved_level
from solver.matching.sampling import common_size, sample
from solver.matching.structures import build_level
from solver.matching.third_order import ThirdOrderTerm
from solver.mesh import triangle_mesh
from solver.optimisation.primal import local_search
from solver.shape import Shape
from synthetic import SyntheticShape, articulated
from tests.solver import shapes

MIRROR = np.array([-1.0, 1.0, 1.0])


def shape_of(figure: SyntheticShape) -> Shape:
    return Shape(triangle_mesh(figure.vertices, figure.faces))


def test_costs_are_squared_differences_over_the_mean_square() -> None:
    source = Shape(shapes.blob())
    target = Shape(shapes.moved(shapes.blob(4), seed=3))
    options = MatchOptions(points=6, metric=("geodesic",)).settled(1.0)
    level = build_level(source, target, 0, (6, 10), options)
    samples = level.source.vertices, level.target.vertices
    term = ThirdOrderTerm.between(source, target, samples, 0.7)
    plain = level.problem(level.all_candidates())
    problem = replace(level, third_order=term).problem(level.all_candidates())
    partners = np.array([3, 1, 9, 0, 4, 7])
    expected = 0.0
    for (i, j, k), volume in zip(term.points, term.source, strict=True):
        difference = volume - term.target[partners[i], partners[j], partners[k]]
        expected += 0.7 * 6 / len(term.points) * difference**2 / term.unit**2
    assert expected > 0.0
    assert problem.energy(partners) == pytest.approx(plain.energy(partners) + expected)


def test_a_mirror_image_costs_more_and_a_copy_nothing() -> None:
    """The identity keeps all distances of both, and the orientation of the copy alone."""
    blob = shapes.blob()
    source, copy = Shape(blob), Shape(shapes.moved(blob, seed=5))
    image = Shape(triangle_mesh(blob.vertices * MIRROR, blob.faces))
    vertices = source.sampling("geodesic", 8).indices
    energies = []
    for target in (copy, image):
        term = ThirdOrderTerm.between(source, target, (vertices, vertices), 1.0)
        candidates = np.argwhere(np.ones((8, 8), dtype=np.bool_))
        costs = term.costs(candidates, 8)
        energies.append(sum(costs.table(t)[tuple(p)] for t, p in enumerate(term.points)))
    assert energies[0] == pytest.approx(0.0, abs=1e-12)
    expected = 8 / len(term.points) * (4.0 * (term.source / term.unit) ** 2).sum()
    assert energies[1] == pytest.approx(expected)
    assert energies[1] > 1.0


@pytest.fixture(scope="module")
def cats() -> tuple[SyntheticShape, SyntheticShape]:
    first, second = (articulated("cat", pose, 900, seed) for seed, pose in enumerate(POSES))
    return first, second


POSES = "standing", "sitting"


def test_the_mirrored_map_of_a_symmetric_body_costs_more(
    cats: tuple[SyntheticShape, SyntheticShape],
) -> None:
    source, target = (shape_of(figure) for figure in cats)
    vertices = source.sampling("geodesic", 12).indices
    tree = KDTree(cats[1].rest)
    energies = []
    for sign in (np.ones(3), MIRROR):
        images = np.asarray(tree.query(cats[0].rest[vertices] * sign)[1], dtype=np.int64)
        term = ThirdOrderTerm.between(source, target, (vertices, images), 1.0)
        costs = term.costs(np.argwhere(np.ones((12, 12), dtype=np.bool_)), 12)
        energies.append(sum(costs.table(t)[tuple(p)] for t, p in enumerate(term.points)))
    assert energies[0] < 0.5 * energies[1]


@pytest.mark.parametrize("points", [6, 24])
def test_bounds_and_order_of_a_match(
    cats: tuple[SyntheticShape, SyntheticShape], points: int
) -> None:
    source, target = (shape_of(figure) for figure in cats)
    options = MatchOptions(points=points, orientation=False, third_order=0.1)
    found = match(source, target, options)
    assert all(level.lower_bound <= level.energy + 1e-12 for level in found.levels)
    assert found.levels[0].certified
    assert found.proof is not None
    assert found.proof.lower_bound <= found.best.energy + 1e-9
    levels, _ = sample(source, target, options.settled(common_size(source, target)), Control())
    with_term = [level.third_order is not None for level in levels]
    assert with_term == [level.metric.name != "geodesic" for level in levels]
    if points == 6:
        # The proof's energy includes the term, and so decides.
        assert found.proof.energy == found.best.energy


WORK = MatchOptions(points=5, coarse_points=5, third_order=1.0).settled(1.0)


@pytest.fixture(scope="module")
def level() -> Level:
    levels, _ = sample(Shape(shapes.blob()), Shape(shapes.blob(4)), WORK, Control())
    return levels[-1]


@pytest.fixture(scope="module")
def local_optima(level: Level) -> list[Hypothesis]:
    """The worst of them first."""
    problem, rng = level.problem(level.all_candidates()), np.random.default_rng(0)
    found = [
        RefinedCorrespondence(problem, partners, problem.energy(partners))
        for _ in range(10)
        for partners in [local_search(problem, rng.permutation(problem.n_targets)[:5])]
    ]
    ordered = sorted(found, key=lambda one: -one.energy)
    return [Hypothesis((solved_level(one, 0.0),)) for one in ordered]


def test_the_work_of_the_proof_is_limited(level: Level, local_optima: list[Hypothesis]) -> None:
    little, much = (
        prove_over_samples(local_optima, level, replace(WORK, proof_work=work), Control())
        for work in (1e-6, 10.0)
    )
    assert little is not None
    assert much is not None
    assert much.solution.certified
    assert not little.solution.certified
    assert little.solution.lower_bound < much.solution.value <= little.solution.value


def test_the_proof_starts_at_the_best_answer(level: Level, local_optima: list[Hypothesis]) -> None:
    worst, best = local_optima[0].energy, local_optima[-1].energy
    found = prove_over_samples(local_optima, level, WORK, Control().within(0.0))
    assert found is not None
    assert found.solution.value <= best < worst


def test_it_decides_between_an_answer_and_its_mirror_image() -> None:
    """A blob and its mirror image: without the term the identity, which no motion attains."""
    blob = shapes.blob()
    image = Shape(triangle_mesh(blob.vertices * MIRROR, blob.faces))
    options = MatchOptions(points=8, orientation=False, metric=("geodesic",))
    plain = match(Shape(blob), image, options)
    third = match(Shape(blob), image, replace(options, third_order=10.0))
    np.testing.assert_array_equal(plain.best.source, plain.best.target)
    assert plain.best.energy == pytest.approx(0.0, abs=1e-9)
    assert (third.best.source != third.best.target).any()
    same = match(Shape(blob), Shape(blob), replace(options, third_order=10.0))
    np.testing.assert_array_equal(same.best.source, same.best.target)


def test_without_the_weight_there_is_no_term() -> None:
    blob = Shape(shapes.blob())
    levels, _ = sample(blob, blob, MatchOptions(points=8).settled(1.0), Control())
    assert all(level.third_order is None for level in levels)
    assert levels[0].problem(levels[0].all_candidates()).triples is NO_TRIPLES


def test_the_minimax_objective_has_no_third_order_term() -> None:
    with pytest.raises(OptionError, match="no third-order term") as caught:
        MatchOptions(points=8, objective=LINF, third_order=0.1)
    assert caught.value.field == "third_order"
