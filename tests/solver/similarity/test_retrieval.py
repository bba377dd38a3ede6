"""Scores of retrieval, by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from solver.arrays import FloatArray
from solver.similarity import rankings, retrieval_scores

BY_HAND = np.array(
    [
        [0.0, 1.0, 4.0, 2.0],  # ranks 1, 3, 2
        [1.0, 0.0, 2.0, 3.0],  # ranks 0, 2, 3
        [4.0, 2.0, 0.0, 3.0],  # ranks 1, 3, 0
        [2.0, 3.0, 3.5, 0.0],  # ranks 0, 1, 2
    ]
)


def test_shapes_are_ranked_without_the_query() -> None:
    assert rankings(BY_HAND).tolist() == [[1, 3, 2], [0, 2, 3], [1, 3, 0], [0, 1, 2]]
    assert rankings(np.zeros((3, 3))).tolist() == [[1, 2], [0, 2], [0, 1]]
    assert rankings(np.zeros((1, 1))).shape == (1, 0)


def test_average_precision_by_hand() -> None:
    found = retrieval_scores(BY_HAND, ["a", "a", "b", "a"])
    # Query 0: its class at ranks 1 and 2. Query 1: at 1 and 3. Query 3: at 1 and 2. 2 is alone.
    assert found.average_precisions[[0, 1, 3]] == pytest.approx([1.0, (1 + 2 / 3) / 2, 1.0])
    assert np.isnan(found.average_precisions[2])
    assert found.mean_average_precision == pytest.approx((1 + 5 / 6 + 1) / 3)
    assert found.precision_at_1 == 1.0


def test_the_worst_ranking() -> None:
    worst = np.array(
        [[0.0, 9.0, 1.0, 1.0], [9.0, 0.0, 1.0, 1.0], [1.0, 1.0, 0.0, 9.0], [1.0, 1.0, 9.0, 0.0]]
    )
    found = retrieval_scores(worst, [1, 1, 2, 2])
    assert found.mean_average_precision == pytest.approx(1 / 3)
    assert found.precision_at_1 == 0.0


def test_a_matrix_that_tells_nothing_apart_has_no_merit_by_the_order_of_its_shapes() -> None:
    found = retrieval_scores(np.zeros((4, 4)), ["a", "a", "b", "b"])
    assert found.mean_average_precision == pytest.approx(1 / 3)
    assert found.precision_at_1 == 0.0


@pytest.mark.parametrize("labels", [["a", "b", "c", "d"], list(range(4))])
def test_without_a_class_of_two_there_is_no_score(labels: list[object]) -> None:
    found = retrieval_scores(BY_HAND, labels)
    assert found.mean_average_precision is None
    assert found.precision_at_1 is None
    assert np.isnan(found.average_precisions).all()


def test_what_cannot_be_scored_is_refused() -> None:
    with pytest.raises(ValueError, match="label for each"):
        retrieval_scores(BY_HAND, ["a"])
    with pytest.raises(ValueError, match="not a number"):
        retrieval_scores(np.full((2, 2), np.nan), ["a", "a"])


@given(
    arrays(np.float64, (6, 6), elements=st.floats(0, 10)),
    st.lists(st.sampled_from("ab"), min_size=6, max_size=6),
    st.permutations(range(6)),
)
def test_scores_are_shares_and_do_not_depend_on_the_order(
    matrix: FloatArray, labels: list[str], order: list[int]
) -> None:
    found = retrieval_scores(matrix, labels)
    other = retrieval_scores(matrix[np.ix_(order, order)], [labels[k] for k in order])
    assert found.mean_average_precision is not None
    assert 0.0 < found.mean_average_precision <= 1.0
    assert other.mean_average_precision == pytest.approx(found.mean_average_precision)
    assert other.precision_at_1 == found.precision_at_1
