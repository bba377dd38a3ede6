"""Answers that are stored in gzip are sent a piece at a time, packed or not."""

import gzip
import os
from tempfile import SpooledTemporaryFile
from typing import BinaryIO, cast

import anyio
import pytest
from starlette.types import Message

from service.http import gzip_response

BODY = os.urandom(1024) * (8 * 1024)

LARGEST = 256 * 1024
"""Most bytes of a piece."""


class InPieces(SpooledTemporaryFile[bytes]):
    """A file of which few bytes are read at a time. Of object storage it comes in such a file."""

    def read(self, size: int = -1, /) -> bytes:
        """Return some bytes."""
        assert 0 <= size <= LARGEST
        return super().read(size)


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
def test_an_answer_is_read_and_sent_in_pieces(accepts: str) -> None:
    sent = Sent()
    scope = {"type": "http", "asgi": {"spec_version": "2.3"}}
    with InPieces(max_size=1) as file:
        file.write(gzip.compress(BODY, 0))
        size = file.tell() if accepts else len(BODY)
        file.seek(0)
        answer = gzip_response(cast(BinaryIO, file), "text/plain", accepts)
        anyio.run(answer, scope, sent.receive, sent.send)
        assert file.closed
    assert sum(sent.sizes) == size == int(sent.headers[b"content-length"])
    assert max(sent.sizes) <= LARGEST
    assert (sent.headers.get(b"content-encoding") == b"gzip") == bool(accepts)
    assert sent.headers[b"vary"] == b"Accept-Encoding"
