"""Generated surfaces that overlap."""

import numpy as np
import pytest

from bench.overlap import OVERLAPS, OVERLAPS_OF_SIDES, generated_overlap, truly_covered


@pytest.mark.parametrize("opposite", [False, True])
@pytest.mark.parametrize("seed", [0, 3])
def test_surfaces_overlap_as_much_as_wanted(seed: int, opposite: bool) -> None:
    _, source, target = generated_overlap(seed, opposite)
    least, most = OVERLAPS_OF_SIDES if opposite else OVERLAPS
    for one, other in ((source, target), (target, source)):
        assert least <= truly_covered(one, other).mean() <= most


def test_opposite_sides_are_missing() -> None:
    """The left of one, and the right of the other: points without partner are on either side."""
    kind, source, target = generated_overlap(0, opposite=True)
    assert kind == "left and right"
    here, there = source.truth, target.truth
    assert here is not None
    assert there is not None
    assert ((here >= 0) | (there >= 0)).all()
    assert 0.1 < (here < 0).mean() < 0.4
    assert 0.1 < (there < 0).mean() < 0.4


def test_points_of_one_person_keep_their_distances() -> None:
    """Along the surface, where neither cut lengthens the way: between near points."""
    _, source, target = generated_overlap(0)
    assert source.truth is not None
    assert target.truth is not None
    common = np.flatnonzero((source.truth >= 0) & (target.truth >= 0))
    first = common[:: len(common) // 40]
    rows = []
    for one in (source, target):
        assert one.truth is not None
        metric = one.shape.metric("geodesic")
        rows.append(metric.distances(one.truth[first])[:, one.truth[common]])
    near = (rows[0] > 0.05) & (rows[0] < 0.3)
    ratios = rows[1][near] / rows[0][near]
    spread = np.quantile(ratios / np.median(ratios), [0.1, 0.9])
    assert spread == pytest.approx([1.0, 1.0], abs=0.2)
