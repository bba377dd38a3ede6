"""Jobs by the beginnings of their ids, at a service of one batch."""

import httpx2
import isomatch
import pytest
from isomatch._cli.job_runs import job_given

from tests.client._http.test_connection import JOB, client_of

BATCH = "d1aec2b3" * 4
KNOWN = (BATCH, f"{BATCH}-1")


def service(request: httpx2.Request) -> httpx2.Response:
    path = request.url.path
    if path == "/v1/jobs":
        return httpx2.Response(200, json={"items": [JOB | {"id": BATCH}], "next_cursor": None})
    if (name := path.rpartition("/")[2]) in KNOWN:
        return httpx2.Response(200, json=JOB | {"id": name})
    document = {"title": "Not found", "status": 404, "detail": f"There is no job {name}."}
    return httpx2.Response(404, json=document, headers={"content-type": "application/problem+json"})


@pytest.mark.parametrize(
    ("given", "found"), [("d1aec2b3", BATCH), ("d1aec2b3-1", f"{BATCH}-1"), (BATCH, BATCH)]
)
def test_a_beginning_names_a_batch_or_a_match_of_it(given: str, found: str) -> None:
    with client_of(service) as client:
        assert job_given(client, given).id == found


@pytest.mark.parametrize(
    ("given", "said"),
    [("d1aec2b3-2", f"no job {BATCH}-2"), ("d1aec2b4-1", "first 8"), ("d1aec-1", "first 8")],
)
def test_what_is_no_match_of_a_batch(given: str, said: str) -> None:
    with client_of(service) as client, pytest.raises(isomatch.NotFound, match=said):
        job_given(client, given)
