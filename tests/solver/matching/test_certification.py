"""Certificates of a match: among the candidates of each level, and over all samples."""

import numpy as np
import pytest

from solver.control import Control
from solver.errors import OptionError
from solver.matching import CANDIDATES, SAMPLES, Match, MatchOptions, match
from solver.matching.certification import prove_over_samples
from solver.matching.sampling import common_size, sample
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import ASYMMETRIC_HUMAN, SyntheticShape, human


def shape_of(figure: SyntheticShape) -> Shape:
    return Shape(triangle_mesh(figure.vertices, figure.faces))


@pytest.fixture(scope="module")
def standing() -> Shape:
    return shape_of(human("standing", ASYMMETRIC_HUMAN, resolution=700, seed=1))


@pytest.fixture(scope="module")
def sitting() -> Shape:
    return shape_of(human("sitting", ASYMMETRIC_HUMAN, resolution=800, seed=2))


@pytest.fixture(scope="module")
def direct(standing: Shape, sitting: Shape) -> Match:
    return match(standing, sitting, MatchOptions(points=24))


@pytest.fixture(scope="module")
def symmetric(standing: Shape, sitting: Shape) -> Match:
    return match(standing, sitting, MatchOptions(points=24, orientation=False))


def test_no_correspondence_of_samples_has_less_energy(direct: Match) -> None:
    proof = direct.proof
    assert proof is not None
    assert proof.certified
    assert proof.lower_bound <= proof.energy
    assert proof.candidates == 24 * proof.target_points
    assert proof.optimum.costs.sum() == pytest.approx(proof.energy)
    assert len(np.unique(proof.optimum.target)) == 24
    for found in (direct.best, *direct.alternatives):
        assert found.energy >= proof.lower_bound - 1e-9


def test_the_direct_answer_stays(standing: Shape, sitting: Shape, direct: Match) -> None:
    plain = match(standing, sitting, MatchOptions(points=24, proof=CANDIDATES))
    assert plain.proof is None
    np.testing.assert_array_equal(plain.best.target, direct.best.target)
    assert plain.best.energy == direct.best.energy
    assert plain.levels[-1].lower_bound == direct.levels[-1].lower_bound


def test_without_orientation_the_answer_has_the_least_energy(symmetric: Match) -> None:
    proof = symmetric.proof
    assert proof is not None
    assert symmetric.best.energy == proof.energy
    assert symmetric.levels[-1].scope == SAMPLES
    assert symmetric.lower_bound == proof.lower_bound
    assert symmetric.certified
    assert symmetric.levels[-1].candidates == proof.candidates


def test_bounds_say_what_they_cover(direct: Match) -> None:
    assert direct.levels[0].scope == SAMPLES
    assert [level.scope for level in direct.levels[1:]] == [CANDIDATES] * (len(direct.levels) - 1)


def test_the_work_is_limited(standing: Shape, sitting: Shape, direct: Match) -> None:
    proof = match(standing, sitting, MatchOptions(points=24, proof_work=1e-6)).proof
    assert proof is not None
    assert direct.proof is not None
    assert proof.lower_bound <= direct.proof.energy <= proof.energy + 1e-9
    assert not proof.certified


def test_landmarks_and_occlusion(standing: Shape, sitting: Shape) -> None:
    pairs = ((5, 9), (200, 310))
    options = MatchOptions(points=16, landmarks=pairs, orientation=False)
    proof = match(standing, sitting, options).proof
    assert proof is not None
    matched = dict(zip(proof.optimum.source.tolist(), proof.optimum.target.tolist(), strict=True))
    assert all(matched[source] == target for source, target in pairs)
    assert proof.candidates == 14 * (proof.target_points - 2) + 2
    cheap = match(standing, sitting, MatchOptions(points=16, occlusion_cost=0.01)).proof
    assert cheap is not None
    assert cheap.energy <= 16 * 0.01
    assert len(cheap.optimum.source) + len(cheap.optimum.unmatched) == 16


def test_nothing_is_proven_over_samples_where_that_is_not_asked_for(
    standing: Shape, sitting: Shape
) -> None:
    minimax = match(standing, sitting, MatchOptions(points=6, objective="linf"))
    assert minimax.proof is None
    with pytest.raises(OptionError):
        MatchOptions(proof="everything")


def test_the_starts_of_a_proof_are_the_hypotheses(standing: Shape, sitting: Shape) -> None:
    options = MatchOptions(points=8, metric=("geodesic",)).settled(common_size(standing, sitting))
    levels, _ = sample(standing, sitting, options, Control())
    found = prove_over_samples([], levels[-1], options, Control())
    assert found is not None
    assert found.solution.certified
