"""Reports on rows of carried attributes that have no value."""

import numpy as np
import pytest

from solver.transfer import Attribute, PullBack
from worker.jobs.carrying import rows_without_value


def onto(vertices: list[int], count: int) -> PullBack:
    """A map from some of `count` vertices, each to a vertex."""
    rows = np.array(vertices, dtype=np.int64)
    corners = np.repeat(rows[:, None], 3, axis=1)
    return PullBack(rows, corners, np.tile([1.0, 0.0, 0.0], (len(rows), 1)), count)


@pytest.mark.parametrize("shape", [(4,), (4, 3)])
def test_rows_that_nothing_reaches_are_counted(shape: tuple[int, ...]) -> None:
    values = Attribute("heat", np.full(shape, np.nan))
    assert rows_without_value([values], [onto([], 4)]) == (
        "4 vertices of the file are not part of the mapped surface",
    )


@pytest.mark.parametrize("shape", [(4,), (4, 3)])
def test_reached_rows_without_a_value_are_counted(shape: tuple[int, ...]) -> None:
    values = np.zeros(shape)
    values[0] = values[3] = np.nan
    (unmapped, unknown) = rows_without_value([Attribute("heat", values)], [onto([0, 1, 2], 4)])
    assert unmapped.startswith("1 vertices of the file")
    assert unknown.startswith("1 vertices have no value of")
