"""Generated surfaces that overlap."""

import numpy as np
import pytest

from bench.overlap import OVERLAPS, generated_overlap, truly_covered


@pytest.mark.parametrize("seed", [0, 3])
def test_surfaces_overlap_as_much_as_wanted(seed: int) -> None:
    _, source, target = generated_overlap(seed)
    for one, other in ((source, target), (target, source)):
        share = truly_covered(one, other).mean()
        assert OVERLAPS[0] <= share <= OVERLAPS[1]


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
