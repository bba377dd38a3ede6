"""Jobs that are not found, by ids of several lengths; without a service."""

import httpx2
import isomatch
import pytest

WHOLE = "a8ba73c3" * 4


def missing(request: httpx2.Request) -> httpx2.Response:
    given = request.url.path.rpartition("/")[2]
    document = {"title": "Not found", "status": 404, "detail": f"There is no job {given}."}
    return httpx2.Response(404, json=document, headers={"content-type": "application/problem+json"})


@pytest.mark.parametrize(("given", "short"), [("9e56", True), (WHOLE[:8], True), (WHOLE, False)])
def test_the_beginning_of_an_id_is_explained(given: str, short: bool) -> None:
    hint = "; ids of jobs have 32 digits"
    transport = httpx2.MockTransport(missing)
    client = isomatch.Client("http://service.test", transport=transport)
    with client, pytest.raises(isomatch.NotFound) as refusal:
        client.job(given)
    assert str(refusal.value) == f"There is no job {given}{hint if short else '.'}"
