"""Halves of generated bodies."""

import numpy as np
import pytest

from bench.collection import KnownShape, generated_collection
from bench.halves import HALVES, half_pairs


@pytest.fixture(scope="module")
def bodies() -> list[KnownShape]:
    return generated_collection(resolution=1000)


def test_opposite_halves_make_the_body(bodies: list[KnownShape]) -> None:
    pairs = list(half_pairs(bodies))
    assert [part.name for part, _ in pairs] == [f"{one.name} {h}" for one in bodies for h in HALVES]
    assert all(part.name.split()[0] != whole.name for part, whole in pairs)
    for number, body in enumerate(bodies):
        first = len(HALVES) * number
        halves = [part for part, _ in pairs[first : first + len(HALVES)]]
        assert body.truth is not None
        assert body.symmetric_truth is not None
        opposite = zip(halves[::2], halves[1::2], (0.95, 0.85, 0.85), strict=True)
        for one, other, least in opposite:
            assert one.truth is not None
            assert other.truth is not None
            ours, theirs = one.truth >= 0, other.truth >= 0
            assert (ours | theirs).mean() > least
            assert (ours & theirs).mean() < 0.15
            assert 0.2 < one.shape.mesh.n_vertices / body.shape.mesh.n_vertices < 0.7


def test_known_points_stay_where_they_were(bodies: list[KnownShape]) -> None:
    known = {one.name: one for one in bodies}
    for part, _ in half_pairs(bodies):
        body = known[part.name.split()[0]]
        assert part.truth is not None
        assert body.truth is not None
        kept = part.truth >= 0
        np.testing.assert_array_equal(
            part.shape.mesh.vertices[part.truth[kept]],
            body.shape.surface.vertices[body.truth[kept]],
        )
