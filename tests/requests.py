"""Requests to a running service, whose answers must be right."""

from typing import Any

import httpx2

from tests.waiting import until


def upload(http: httpx2.Client, data: bytes) -> str:
    """Upload a mesh and return its id."""
    answer = http.post("/v1/shapes", files={"file": ("a.off", data)})
    assert answer.status_code in (200, 201), answer.text
    shape: str = answer.json()["id"]
    return shape


def ask(
    http: httpx2.Client,
    source: str,
    target: str | None = None,
    key: str | None = None,
    **parameters: object,
) -> str:
    """Have a shape matched, with itself if no other one is given, and return the job's id."""
    headers = {} if key is None else {"Idempotency-Key": key}
    body = {"source": source, "target": target or source, **parameters}
    answer = http.post("/v1/matches", json=body, headers=headers)
    assert answer.status_code == 202, answer.text
    job: str = answer.json()["id"]
    return job


def job_of(http: httpx2.Client, job: str, wait: float = 0.0) -> dict[str, Any]:
    """Return a job as it is, after some seconds or its end."""
    answer = http.get(f"/v1/jobs/{job}", params={"wait": wait})
    assert answer.status_code == 200, answer.text
    record: dict[str, Any] = answer.json()
    return record


def until_begun(http: httpx2.Client, job: str) -> None:
    """Wait until a job is in the middle of its matching."""

    def begun() -> bool:
        record = job_of(http, job)
        assert record["state"] in ("queued", "running"), record
        return bool(record["state"] == "running" and record["progress"]["fraction"] >= 0.4)

    until(begun)
