"""Placement of points at their images under a map of all vertices."""

from dataclasses import replace

import numpy as np
import pytest

from solver.labelling import UNMATCHED
from solver.matching import (
    Level,
    MatchOptions,
    add_target_samples,
    build_level,
    build_varadhan_level,
    match,
    match_near_images,
)
from solver.mesh import triangle_mesh
from solver.shape import Shape
from synthetic import human
from tests.solver import shapes

OPTIONS = MatchOptions(points=12).settled(1.0)


@pytest.fixture(scope="module")
def blob() -> Shape:
    return Shape(shapes.blob())


@pytest.fixture(scope="module", params=["varadhan", "geodesic"])
def level(blob: Shape, request: pytest.FixtureRequest) -> Level:
    """A shape against itself."""
    build, index = (build_varadhan_level, 0) if request.param == "varadhan" else (build_level, 1)
    return build(blob, blob, index, (12, 24), OPTIONS)


def test_images_are_added_after_the_samples(blob: Shape, level: Level) -> None:
    """What is known of other hypotheses, by number and by energy, stays true."""
    images = np.concatenate([level.target.vertices[:6], np.arange(200, 206)])
    wider = add_target_samples(blob, blob, level, images)
    known = len(level.target.vertices)
    np.testing.assert_array_equal(wider.target.vertices[:known], level.target.vertices)
    assert set(images) <= set(wider.target.vertices.tolist())
    assert len(np.unique(wider.target.vertices)) == len(wider.target.vertices)
    partners = np.random.default_rng(0).permutation(known)[:12]
    before, after = (one.problem(one.all_candidates()).energy(partners) for one in (level, wider))
    assert after == pytest.approx(before)
    assert wider.distortion(partners).linf == pytest.approx(level.distortion(partners).linf)


def test_the_identity_is_found_between_the_samples(blob: Shape) -> None:
    """Sampled from another start, no target sample need be a source sample."""
    sources = build_level(blob, blob, 1, (12, 24), OPTIONS)
    others = build_level(blob, blob, 1, (12, 24), OPTIONS, np.array([[0, 77]]))
    mixed = Level(
        1, sources.metric, sources.descriptor, sources.source, others.target, 1.0, 0.05, np.inf
    )
    images = sources.source.vertices
    found = match_near_images(
        blob, add_target_samples(blob, blob, mixed, images), images, blob.size
    )
    assert found is not None
    wider = add_target_samples(blob, blob, mixed, images)
    np.testing.assert_array_equal(wider.target.vertices[found.partners], images)
    assert found.energy == pytest.approx(0.0, abs=1e-12)


def test_points_stay_within_reach_of_their_images(blob: Shape, level: Level) -> None:
    images = np.random.default_rng(1).permutation(blob.n_vertices)[:12]
    wider = add_target_samples(blob, blob, level, images)
    found = match_near_images(blob, wider, images, blob.size)
    assert found is not None
    places = {vertex: place for place, vertex in enumerate(wider.target.vertices.tolist())}
    own = [places[image] for image in images.tolist()]
    assert (wider.target.distances[own, found.partners] <= 0.05).all()
    assert found.energy <= found.problem.energy(np.array(own)) + 1e-12


def test_reach_is_that_of_the_whole_also_on_a_part(blob: Shape, level: Level) -> None:
    """A part has less area than the whole whose unit the reach has."""
    images = np.random.default_rng(1).permutation(blob.n_vertices)[:12]
    wider = add_target_samples(blob, blob, level, images)
    counts = []
    for unit in (1.0, 4.0):
        found = match_near_images(blob, wider, images, unit * blob.size)
        assert found is not None
        counts.append(found.problem.n_candidates)
    assert counts[0] < counts[1]


def test_coinciding_images_are_not_placed(blob: Shape, level: Level) -> None:
    images = np.full(12, 5)
    wider = add_target_samples(blob, blob, level, images)
    assert match_near_images(blob, wider, images, blob.size) is None


@pytest.mark.parametrize("metric", ["geodesic", "commute_time", "biharmonic"])
def test_reach_does_not_depend_on_metric_and_scale(metric: str) -> None:
    """Commute times are no lengths, and the same however large a shape is."""
    images = np.random.default_rng(1).permutation(shapes.blob().n_vertices)[:12]
    mapped = np.arange(12) % 4 != 0
    options = MatchOptions(points=12, metric=(metric,))
    found, matched = [], []
    for scale in (1.0, 300.0):
        mesh = shapes.blob()
        large = Shape(triangle_mesh(scale * mesh.vertices, mesh.faces), normalise=False)
        level = build_level(large, large, 0, (12, 24), options.settled(large.size))
        wider = add_target_samples(large, large, level, images)
        placed = match_near_images(large, wider, images, large.size)
        assert placed is not None
        pairs = placed.problem.candidates
        apart = large.metric("geodesic").between(np.concatenate([images, wider.target.vertices]))
        assert (apart[pairs[:, 0], 12 + pairs[:, 1]] <= 0.05 * large.size).all()
        found.append(pairs)
        may_lack = replace(wider, occlusion_cost=0.1)
        partly = match_near_images(large, may_lack, images, large.size, mapped)
        assert partly is not None
        assert (partly.partners[~mapped] == UNMATCHED).all()
        matched.append(partly.partners)
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(matched[0], matched[1])


def test_the_answer_of_a_single_level_is_bounded() -> None:
    one, other = (Shape(shapes.blob(seed)) for seed in (3, 4))
    options = MatchOptions(points=8, metric=("geodesic",), dense=True)
    (level,) = match(one, other, options).levels
    assert 0.0 < level.lower_bound <= level.energy
    assert level.certified


@pytest.mark.parametrize("points", [8, 20])
def test_an_answer_is_near_its_images(points: int) -> None:
    one, other = (
        human("standing", resolution=900, seed=1),
        human("walking", resolution=1000, seed=2),
    )
    source, target = (Shape(triangle_mesh(each.vertices, each.faces)) for each in (one, other))
    found = match(source, target, MatchOptions(points=points, dense=True))
    assert found.dense is not None
    images = found.dense.target[found.best.source]
    apart = target.metric("geodesic").between(np.concatenate([images, found.best.target]))
    assert apart[np.arange(points), points + np.arange(points)].max() < 0.1
    assert found.levels[-1].energy == found.best.energy
    assert found.levels[-1].lower_bound <= found.best.energy
    assert found.levels[-1].target_points > 4 * points
    assert len(np.unique(found.best.target)) == points
