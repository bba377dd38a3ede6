"""Matches that are asked for and waited for over HTTP."""

import httpx2

from tests.service.conftest import Json

Shapes = tuple[str, str]


def ask(http: httpx2.Client, shapes: Shapes, **parameters: object) -> Json:
    body = {"source": shapes[0], "target": shapes[1], **parameters}
    answer = http.post("/v1/matches", json=body)
    assert answer.status_code == 202, answer.text
    job: Json = answer.json()
    return job


def wait(http: httpx2.Client, job: Json, seconds: float = 240) -> Json:
    while True:
        answer = http.get(job["links"]["self"], params={"wait": min(seconds, 60.0)})
        assert answer.status_code == 200, answer.text
        found: Json = answer.json()
        seconds -= 60.0
        if found["state"] not in ("queued", "running") or seconds <= 0.0:
            return found


def matched(http: httpx2.Client, shapes: Shapes, **parameters: object) -> Json:
    job = wait(http, ask(http, shapes, **parameters))
    assert job["state"] == "succeeded", job["error"]
    return job
