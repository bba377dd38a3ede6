"""Transfer by the client and by the service: one table of values, run against both."""

import io
import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from isomatch import Match
from isomatch._results import TransferKind

from solver.errors import SolverError
from solver.transfer import PullBack, carried, selected
from solver.transfer.files import read_attributes
from tests.client._results.test_transfer import CORNERS, DENSE, EXAMPLE, WEIGHTS

MATCH = Match.from_json(json.dumps({**EXAMPLE, "dense": DENSE}))
PULL_BACK = PullBack(np.array([0, 2, 3]), np.array(CORNERS), np.array(WEIGHTS), 4)


@dataclass(frozen=True)
class Case:
    """Values of three vertices, and those of the four of the target; None if they are refused."""

    kind: TransferKind
    values: Any
    expected: Any
    influences: int | None = None


BYTES = np.array([b"arm", b"leg", "Fuß".encode()])
NAN = np.nan
EQUAL = np.full((3, 4), 0.25)
CASES = {
    "whole numbers": Case("labels", [5, 7, 7], [5, -1, 7, 5]),
    "booleans": Case("labels", [True, False, False], [1, -1, 0, 1]),
    "unsigned": Case("labels", np.array([5, 7, 7], np.uint64), [5, -1, 7, 5]),
    "unsigned beyond 2^63": Case("labels", np.array([2**63 + 1, 1, 2], np.uint64), None),
    "floats": Case("labels", [5.0, 7.0, 7.0], [5, -1, 7, 5]),
    "floats with nan": Case("labels", [5.0, 7.0, NAN], [5, -1, -1, 5]),
    "nan alone": Case("labels", [NAN, NAN, NAN], None),
    "fractions": Case("labels", [5.0, 7.5, 7.0], None),
    "floats beyond 2^53": Case("labels", [5.0, 1e300, 7.0], None),
    "infinite labels": Case("labels", [5.0, np.inf, 7.0], None),
    "text": Case("labels", ["arm", "leg", "leg"], ["arm", "", "leg", "arm"]),
    "bytes": Case("labels", BYTES, ["arm", "", "Fuß", "arm"]),
    "bytes that are no text": Case("labels", np.array([b"\xff"] * 3), None),
    "objects": Case("labels", np.array(["a", "b", "b"], dtype=object), None),
    "complex": Case("labels", np.array([1j, 2, 3]), None),
    "columns of labels": Case("labels", [[1, 2], [3, 4], [5, 6]], None),
    "scalars with nan": Case("scalars", [0.0, 4.0, NAN], [4 / 3, NAN, NAN, 1.0]),
    "infinite": Case("scalars", [0.0, np.inf, 1.0], None),
    "first joints of equal weights": Case(
        "skinning", EQUAL, [[0.5, 0.5, 0, 0], [NAN] * 4, [0.5, 0.5, 0, 0], [0.5, 0.5, 0, 0]], 2
    ),
    "as many influences as joints": Case(
        "skinning", EQUAL, [[0.25] * 4, [NAN] * 4, [0.25] * 4, [0.25] * 4], 4
    ),
    "great weights": Case(
        "skinning", np.full((3, 2), 1e308), [[0.5, 0.5], [NAN, NAN], [0.5, 0.5], [0.5, 0.5]]
    ),
    "no weights": Case("skinning", np.zeros((3, 2)), [[0, 0], [NAN, NAN], [0, 0], [0, 0]]),
    "negative weights": Case("skinning", [[1.0, -1.0]] * 3, None),
    "no influences": Case("skinning", EQUAL, None, 0),
    "negative influences": Case("skinning", EQUAL, None, -1),
}


def by_service(case: Case) -> npt.NDArray[Any]:
    stream = io.BytesIO()
    name = "weights" if case.kind == "skinning" else "values"
    # The client refuses objects before it sends them.
    np.savez(stream, allow_pickle=True, **{name: np.asarray(case.values)})
    (chosen,) = selected(read_attributes(stream.getvalue(), "npz"), case.kind)
    return carried(chosen, case.kind, PULL_BACK, case.influences).values


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_client_and_service_carry_the_same(case: Case) -> None:
    if case.expected is None:
        with pytest.raises(SolverError):
            by_service(case)
        with pytest.raises(ValueError, match=r"labels|influences|infinite|negative"):
            MATCH.transfer(case.values, case.kind, influences=case.influences)
        return
    expected = np.asarray(case.expected)
    if case.kind != "labels":
        expected = expected.astype(np.float64)
    local = MATCH.transfer(case.values, case.kind, influences=case.influences)
    for found in (by_service(case), local):
        assert found.dtype.kind == (
            "f" if case.kind in ("scalars", "skinning") else expected.dtype.kind
        )
        if found.dtype.kind == "f":
            np.testing.assert_allclose(found, expected)
        else:
            np.testing.assert_array_equal(found, expected)


def test_influences_are_of_skinning_alone() -> None:
    with pytest.raises(ValueError, match="only skinning weights have influences, not 'scalars'"):
        MATCH.transfer([1.0, 2.0, 3.0], influences=4)
