"""Logs of the whole service: one JSON object per line, with the id of the request."""

import json
from pathlib import Path
from typing import Any

import httpx2

from demo.stack import Stack
from tests.client.shapes import write_blobs
from tests.waiting import until


def lines(stack: Stack, request_id: str) -> list[dict[str, Any]]:
    # The last line may just be written.
    whole = stack.log.read_text().rpartition("\n")[0]
    found = [json.loads(line) for line in whole.splitlines()]
    return [line for line in found if line.get("request_id") == request_id]


def all_told(stack: Stack, request_id: str) -> list[dict[str, Any]]:
    """Log lines of a request, once those of the ends of its jobs are written."""

    def found() -> list[dict[str, Any]] | None:
        told = lines(stack, request_id)
        queued, done = (
            {line["job_id"] for line in told if line["event"] == event}
            for event in ("queued", "done")
        )
        whole = queued and queued == done and "request" in [line["event"] for line in told]
        return told if whole else None

    return until(found, pause=0.05)


def test_log_lines_of_a_request_have_its_id(stack: Stack, tmp_path: Path) -> None:
    path, _ = write_blobs(tmp_path)
    # Bytes that no other test sends: somebody has to read them, and to compute their spectrum.
    data = path.read_bytes() + b"# for the log\n"
    with httpx2.Client(base_url=stack.url, timeout=300.0) as http:
        files = {"file": ("a.off", data)}
        names = {"upload": {"X-Request-ID": "an-upload"}, "match": {"X-Request-ID": "a-match"}}
        shape = http.post("/v1/shapes", files=files, headers=names["upload"]).json()["id"]
        body = {"source": shape, "target": shape, "points": 8, "orientation": False}
        job = http.post("/v1/matches", json=body, headers=names["match"]).json()
        http.get(job["links"]["self"], params={"wait": 60})
    for request_id, kinds in (("an-upload", {"validation"}), ("a-match", {"spectrum", "match"})):
        told = all_told(stack, request_id)
        by_the_api = [line for line in told if line["process"] == "api"]
        by_workers = [line for line in told if line["process"] == "worker"]
        queued = {line["job_id"]: line["kind"] for line in by_the_api if line["event"] == "queued"}
        assert set(queued.values()) == kinds
        assert [line["event"] for line in by_the_api].count("request") == 1
        for event in ("begun", "done"):
            seen = [line for line in by_workers if line["event"] == event]
            assert {line["job_id"]: line["kind"] for line in seen} == queued
    assert job["id"] in {line["job_id"] for line in lines(stack, "a-match") if "job_id" in line}
