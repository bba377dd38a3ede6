"""Answers that are files, sent a piece at a time."""

import os
from collections.abc import Iterator, Mapping
from typing import BinaryIO

from fastapi.responses import StreamingResponse
from starlette.background import BackgroundTask

from broker.store import pieces


def file_response(
    file: BinaryIO, media_type: str, headers: Mapping[str, str] | None = None
) -> StreamingResponse:
    """Return an answer with the rest of a file, which is closed in the end.

    Parameters
    ----------
    file
        The file; a mesh may have 256 MiB, of which a piece at a time is in memory.
    media_type
        Its type.
    headers
        Further headers.
    """
    start = file.tell()
    size = file.seek(0, os.SEEK_END) - start
    file.seek(start)
    return pieces_response(pieces(file), size, file, media_type, headers)


def pieces_response(
    content: Iterator[bytes],
    size: int,
    file: BinaryIO,
    media_type: str,
    headers: Mapping[str, str] | None = None,
) -> StreamingResponse:
    """Return an answer with content that is made of a file, which is closed in the end.

    Parameters
    ----------
    content
        The pieces of the body.
    size
        Number of bytes of all pieces.
    file
        The file that they are made of.
    media_type
        Type of the content.
    headers
        Further headers.
    """

    def send() -> Iterator[bytes]:
        with file:
            yield from content

    every = {"Content-Length": str(size), **(headers or {})}
    # The client may leave before the first piece is asked for.
    closing = BackgroundTask(file.close)
    return StreamingResponse(send(), media_type=media_type, headers=every, background=closing)
