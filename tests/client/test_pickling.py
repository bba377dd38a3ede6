"""Errors and results in other processes: pickled and copied."""

import copy
import json
import pickle
from collections.abc import Callable, Iterator
from typing import Any

import httpx2
import isomatch
import numpy as np
import pytest
from isomatch._errors import IsomatchError, JobCancelled, JobFailed, MissingExtra, WaitTimeout
from isomatch._operations.results import _RESULTS
from isomatch._problem import FieldProblem, Problem
from isomatch._results import ArrayResult, DrawableSource, Result

from service.http.openapi.examples import EXAMPLES
from tests.worker.figures import blob

PROBLEM = Problem(
    title="Invalid",
    status=422,
    detail="no",
    errors=(FieldProblem(field="body.points", message="too few"),),
)
JOB: dict[str, Any] = {
    "id": "1",
    "kind": "match",
    "state": "queued",
    "progress": {"stage": "queued", "fraction": 0.0},
    "created": "2026-01-01T00:00:00Z",
    "started": None,
    "ended": None,
    "position": 0,
    "error": None,
    "caller": None,
    "webhook": None,
}
DOCUMENTS: dict[str, Any] = EXAMPLES["answers"]["get_result"]["200"]


def pickled(given: Any) -> Any:
    return pickle.loads(pickle.dumps(given))


COPIES = pytest.mark.parametrize(
    "copied", [pickled, copy.copy, copy.deepcopy], ids=["pickle", "copy", "deepcopy"]
)


def _kinds(base: type[IsomatchError] = IsomatchError) -> Iterator[type[IsomatchError]]:
    for kind in base.__subclasses__():
        yield kind
        yield from _kinds(kind)


def _error(kind: type[IsomatchError]) -> IsomatchError:
    """An error of a class, with all that it can carry."""
    if issubclass(kind, isomatch.ProblemError):
        return kind(PROBLEM, 2.5)
    if issubclass(kind, JobFailed):
        return kind("a8ba", PROBLEM)
    if issubclass(kind, JobCancelled):
        return kind("a8ba")
    if issubclass(kind, WaitTimeout):
        return kind("job a8ba", 3.0)
    if issubclass(kind, MissingExtra):
        return kind("plot", "plotly")
    return kind("what is wrong")


@COPIES
@pytest.mark.parametrize("kind", list(dict.fromkeys(_kinds())))
def test_every_error_survives(
    kind: type[IsomatchError], copied: Callable[[IsomatchError], IsomatchError]
) -> None:
    error = _error(kind)
    error.add_note("of specimen 3")
    again = copied(error)
    assert type(again) is kind
    assert str(again) == str(error)
    assert again.args == error.args
    assert vars(again) == vars(error)
    if isinstance(again, ImportError | OSError):
        assert repr(again) == repr(error)


def _result(kind: type[Result]) -> Result:
    """The example of a result, as a client returns it."""
    documents = [one for name, one in DOCUMENTS.items() if _RESULTS.get(name) is kind]
    result = kind.from_json(json.dumps(documents[0]))
    result._drawables = DrawableSource(lambda drawn_id: pytest.fail(f"requested {drawn_id}"))
    if isinstance(result, ArrayResult):
        result._archive = b"arrays"
    return result


@COPIES
@pytest.mark.parametrize("kind", sorted(_RESULTS))
def test_every_result_survives(kind: str, copied: Callable[[Result], Result]) -> None:
    result = _result(_RESULTS[kind])
    again = copied(result)
    assert type(again) is type(result)
    assert again == result
    assert again.to_json() == result.to_json()
    if isinstance(result, ArrayResult) and isinstance(again, ArrayResult):
        assert again._archive == result._archive


@pytest.mark.parametrize("kind", sorted(_RESULTS))
def test_results_are_compared_by_their_fields(kind: str) -> None:
    one, other = _result(_RESULTS[kind]), _result(_RESULTS[kind])
    _read_arrays(one)
    _read_arrays(other)
    assert one == other
    assert one.model_copy(update={"job": "another"}) != other
    assert one != "a result"


def _read_arrays(result: Result) -> None:
    """Read all arrays of a result, which it keeps."""
    if isinstance(result, isomatch.Dissimilarities):
        assert result.lower_bound_matrix.shape == result.matrix.shape
    if isinstance(result, isomatch.Match):
        assert len(result.pairs) == len(result.costs)


def test_unknown_entries_of_partial_dissimilarities_are_equal() -> None:
    document: dict[str, object] = {"job": "a8ba", "state": "running", "labels": None}
    document |= {"shapes": ["a", "b"], "pairs": 1, "pairs_done": 0}
    document |= {"matrix": [[0.0, None], [None, 0.0]]}
    one, other = (isomatch.PartialDissimilarities.model_validate(document) for _ in range(2))
    assert one == other
    assert one != other.model_copy(update={"matrix": np.zeros((2, 2))})


def test_an_unpickled_result_says_what_to_draw_it_with() -> None:
    match = _result(isomatch.Match)
    assert copy.deepcopy(match)._drawables.request is match._drawables.request
    with pytest.raises(ValueError, match=r"give what is drawn, as in result\.plot\(client\.geo"):
        pickled(match).plot()


@COPIES
def test_a_surface_survives(copied: Callable[[isomatch.Geometry], isomatch.Geometry]) -> None:
    vertices, faces = blob(2)
    surface = isomatch.Geometry(vertices, faces, np.arange(len(vertices)), None)
    assert np.array_equal(copied(surface).vertices, vertices)


def test_connections_say_what_to_send_instead() -> None:
    transport = httpx2.MockTransport(lambda _: httpx2.Response(200, json=JOB))
    with isomatch.Client("http://service.test", transport=transport) as client:
        job = client.job("1")
        for connected in (client, job, isomatch.AsyncClient("http://service.test")):
            with pytest.raises(TypeError, match="make a client in each, and send ids"):
                pickle.dumps(connected)


def test_jobs_are_compared_by_their_ids() -> None:
    states = iter(("queued", "succeeded", "queued"))
    transport = httpx2.MockTransport(
        lambda request: httpx2.Response(
            200, json=JOB | {"id": request.url.path[-1], "state": next(states)}
        )
    )
    with isomatch.Client("http://service.test", transport=transport) as client:
        one, same, other = client.job("1"), client.job("1"), client.job("2")
    assert one == same
    assert len({one, same, other}) == 2
    assert one != "1"
    assert (one.names, one.stage) == ((), "next in the queue")
