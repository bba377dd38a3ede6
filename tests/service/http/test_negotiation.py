"""Answers that are stored in gzip are sent a piece at a time, packed or not."""

import gzip
import io
import os
import tracemalloc

import anyio
import pytest
from starlette.types import Message

from service.http import gzip_response

BODY = os.urandom(1024) * (8 * 1024)


class Sent:
    """An answer as its client receives it, of which only the sizes of the pieces are kept."""

    def __init__(self) -> None:
        self.headers: dict[bytes, bytes] = {}
        self.sizes: list[int] = []

    async def receive(self) -> Message:
        """Stay."""
        await anyio.sleep_forever()
        raise AssertionError

    async def send(self, message: Message) -> None:
        """Take a part of the answer."""
        if message["type"] == "http.response.start":
            self.headers = dict(message["headers"])
        elif message["body"]:
            self.sizes.append(len(message["body"]))


@pytest.mark.parametrize("accepts", ["", "gzip"])
def test_an_answer_is_never_in_memory_as_a_whole(accepts: str) -> None:
    packed = io.BytesIO(gzip.compress(BODY, 0))
    size = len(packed.getvalue()) if accepts else len(BODY)
    sent = Sent()
    scope = {"type": "http", "asgi": {"spec_version": "2.3"}}
    tracemalloc.start()
    anyio.run(gzip_response(packed, "text/plain", accepts), scope, sent.receive, sent.send)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert packed.closed
    assert sum(sent.sizes) == size == int(sent.headers[b"content-length"])
    assert peak < len(BODY) / 4
    assert (sent.headers.get(b"content-encoding") == b"gzip") == bool(accepts)
    assert sent.headers[b"vary"] == b"Accept-Encoding"
