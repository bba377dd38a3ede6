"""Transfer of arrays along a dense match, computed by the client."""

import json
from typing import Any

import numpy as np
import pytest
from isomatch import Match

from service.http.openapi.examples import EXAMPLES

EXAMPLE: dict[str, Any] = EXAMPLES["answers"]["get_result"]["200"]["match"]
CORNERS, WEIGHTS = (
    [[0, 1, 2], [2, 1, 0], [1, 2, 0]],
    [[0.5, 0.25, 0.25], [1, 0, 0], [0.2, 0.2, 0.6]],
)
DENSE = {
    "hypothesis": 0,
    "source": [0, 1, 2],
    "target": [0, 2, 3],
    "faces": [[0, 2, 3]] * 3,
    "barycentric": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    # Vertex 1 of the target's file is no part of its surface.
    "inverse": {"target": [0, 2, 3], "source": [0, 2, 0], "faces": CORNERS, "barycentric": WEIGHTS},
}
MATCH = Match.from_json(json.dumps({**EXAMPLE, "dense": DENSE}))


def test_values_of_the_source_are_those_at_the_images_of_the_target() -> None:
    found = MATCH.transfer([0.0, 4.0, 8.0])
    np.testing.assert_allclose(found, [3.0, np.nan, 8.0, 2.4])
    vectors = MATCH.transfer(np.arange(6.0).reshape(3, 2), "vectors")
    np.testing.assert_allclose(vectors[[0, 2, 3]], [[1.5, 2.5], [4.0, 5.0], [1.2, 2.2]])


def test_values_of_the_target_go_the_other_way() -> None:
    found = MATCH.transfer([1.0, 7.0, 2.0, 3.0], direction="target_to_source")
    np.testing.assert_allclose(found, [1.0, 2.0, 3.0])


def test_labels_stay_labels() -> None:
    assert MATCH.transfer([5, 7, 7], "labels").tolist() == [5, -1, 7, 5]
    assert MATCH.transfer(["a", "b", "b"], "labels").tolist() == ["a", "", "b", "a"]
    unsigned = np.array([5, 7, 7], dtype=np.uint8)
    assert MATCH.transfer(unsigned, "labels").tolist() == [5, -1, 7, 5]
    mask = np.array([True, False, False])
    assert MATCH.transfer(mask, "labels").tolist() == [1, -1, 0, 1]


def test_colours_of_bytes_stay_bytes() -> None:
    colors = np.array([[0, 0, 0], [100, 0, 8], [200, 0, 255]], dtype=np.uint8)
    found = MATCH.transfer(colors, "colors")
    assert found.dtype == np.uint8
    assert found[[0, 2]].tolist() == [[75, 0, 66], [200, 0, 255]]


def test_sums_of_weights_are_one() -> None:
    weights = np.array([[2.0, 0.0, 2.0], [0.0, 3.0, 0.0], [1.0, 1.0, 0.0]])
    found = MATCH.transfer(weights, "skinning")[[0, 2, 3]]
    np.testing.assert_allclose(found.sum(axis=1), 1.0)
    np.testing.assert_allclose(found[0], [0.375, 0.375, 0.25])
    few = MATCH.transfer(weights, "skinning", influences=1)[3]
    assert sorted(few) == [0.0, 0.0, 1.0]


def test_values_with_gaps_go_there_and_back() -> None:
    there = MATCH.transfer([1.0, 2.0, 3.0], "scalars")
    assert np.isnan(there).any()
    back = MATCH.transfer(there, "scalars", "target_to_source")
    gone = MATCH.transfer(np.isnan(there).astype(float), "scalars", "target_to_source")
    np.testing.assert_array_equal(np.isnan(back), np.isnan(gone) | (gone > 0.5))
    whole = MATCH.transfer(np.nan_to_num(there), "scalars", "target_to_source")
    np.testing.assert_allclose(back[gone == 0.0], whole[gone == 0.0])


def test_rows_are_those_of_the_file() -> None:
    """Of a part, the last vertices of the whole may have no partner."""
    part = MATCH.model_copy(update={"source_file_vertices": 3, "target_file_vertices": 6})
    assert part.transfer([5, 7, 7], "labels").tolist() == [5, -1, 7, 5, -1, -1]
    for given in ([1.0, 2.0], [1.0] * 4):
        with pytest.raises(ValueError, match=f"{len(given)} rows of values, but .* has 3 vertices"):
            part.transfer(given)
    for count in (3, 4, 5, 7):  # vertices 4 and 5 have no partner
        with pytest.raises(ValueError, match=f"{count} rows of values, but .* has 6 vertices"):
            part.transfer(np.arange(count), direction="target_to_source")
    assert part.transfer(np.arange(6), direction="target_to_source").tolist() == [0, 2, 3]
    assert part.vertex_map().tolist() == [0, 2, 3]
    assert part.vertex_map("target_to_source").tolist() == [0, -1, 2, 0, -1, -1]


def test_landmarks_go_along_the_map() -> None:
    assert MATCH.transfer([2, 0], "landmarks").tolist() == [3, 0]
    assert MATCH.transfer([3], "landmarks", "target_to_source").tolist() == [0]
    assert MATCH.transfer([3, 1, 2], "landmarks", "target_to_source").tolist() == [0, -1, 2]
    for beyond in (-1, 4):
        with pytest.raises(ValueError, match=f"{beyond} is no vertex of .*, which has 4"):
            MATCH.transfer([0, beyond], "landmarks", "target_to_source")
    assert MATCH.transfer([], "landmarks").tolist() == []
    with pytest.raises(ValueError, match="whole numbers, not float64"):
        MATCH.transfer([0.5], "landmarks")


@pytest.mark.parametrize(
    ("values", "kind", "message"),
    [
        ([1.0, 2.0], "scalars", "2 rows of values, but .* has at least 3 vertices"),
        ([], "scalars", "0 rows of values"),
        (7.0, "labels", "0 rows of values"),
        ([1.0, np.inf, 0.0], "scalars", "infinite"),
        ([1.0, 2.0, 3.0], "skinning", "column for each joint"),
        ([[1.0], [-2.0], [3.0]], "skinning", "negative"),
        ([1.0, 2.0, 3.0], "texture", "kind is one of"),
    ],
)
def test_values_that_cannot_be_carried(values: Any, kind: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        MATCH.transfer(values, kind)


def test_a_match_of_points_alone_carries_nothing() -> None:
    sparse = Match.from_json(json.dumps(EXAMPLE))
    with pytest.raises(ValueError, match="dense=True"):
        sparse.transfer([1.0, 2.0, 3.0])
    with pytest.raises(TypeError, match="give an array with a row for each vertex"):
        MATCH.transfer(None)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="direction is"):
        MATCH.transfer([1.0, 2.0, 3.0], direction="back")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="direction is"):
        MATCH.vertex_map("back")  # type: ignore[arg-type]
