"""Answers that are stored in gzip are sent a piece at a time, packed or not."""

import gzip
import os
import tracemalloc
from tempfile import SpooledTemporaryFile
from typing import BinaryIO, cast

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
    sent = Sent()
    scope = {"type": "http", "asgi": {"spec_version": "2.3"}}
    # Of object storage it comes through such a file.
    with SpooledTemporaryFile(max_size=1) as file:
        file.write(gzip.compress(BODY, 0))
        size = file.tell() if accepts else len(BODY)
        file.seek(0)
        answer = gzip_response(cast(BinaryIO, file), "text/plain", accepts)
        tracemalloc.start()
        anyio.run(answer, scope, sent.receive, sent.send)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert file.closed
    assert sum(sent.sizes) == size == int(sent.headers[b"content-length"])
    assert peak < len(BODY) / 4
    assert (sent.headers.get(b"content-encoding") == b"gzip") == bool(accepts)
    assert sent.headers[b"vary"] == b"Accept-Encoding"
