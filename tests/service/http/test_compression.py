"""Answers that are text are compressed, once, for clients that accept gzip."""

import gzip

import httpx2
import pytest

from tests.service.conftest import Upload
from tests.worker.figures import blob_file


def raw(http: httpx2.Client, path: str, accepted: str = "gzip") -> tuple[httpx2.Headers, bytes]:
    """The headers of an answer, and its bytes as they are sent."""
    with http.stream("GET", path, headers={"Accept-Encoding": accepted}) as answer:
        assert answer.status_code == 200
        return answer.headers, b"".join(answer.iter_raw())


@pytest.mark.parametrize("path", ["/openapi.json", "/v1/structures"])
def test_json_is_compressed(http: httpx2.Client, path: str) -> None:
    headers, body = raw(http, path)
    assert headers["content-encoding"] == "gzip"
    assert int(headers["content-length"]) == len(body)
    assert "Accept-Encoding" in headers["vary"]
    for refused in ("gzip;q=0", "identity", ""):
        plain, whole = raw(http, path, refused)
        assert "content-encoding" not in plain
        assert gzip.decompress(body) == whole
        assert len(body) < 0.5 * len(whole)


def test_nothing_is_compressed_twice_or_in_vain(http: httpx2.Client, upload: Upload) -> None:
    shape = upload(blob_file(3, seed=71))
    headers, body = raw(http, "/page/style.css")
    assert headers["content-encoding"] == "gzip"
    assert gzip.decompress(body)[:2] != b"\x1f\x8b"
    # Bytes of any kind, and what is short.
    for path in (f"/v1/shapes/{shape['id']}/mesh", f"/v1/shapes/{shape['id']}"):
        headers, body = raw(http, path)
        assert "content-encoding" not in headers
        assert int(headers["content-length"]) == len(body)
