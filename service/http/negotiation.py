"""Content negotiation of gzip, and conditional requests (RFC 9110, sections 12.5.3 and 13.1.2)."""

import gzip
import os
import re
from collections.abc import Iterator, Mapping
from typing import Annotated, BinaryIO, Final, cast

from fastapi import Header
from fastapi.responses import StreamingResponse

from broker.store import pieces
from service.http.file_responses import file_response, pieces_response

_REFUSED: Final = re.compile(r"q=0(\.0{0,3})?")

AcceptEncoding = Annotated[str, Header(include_in_schema=False)]
IfNoneMatch = Annotated[
    str | None,
    Header(alias="If-None-Match", description="ETags of the versions the client has."),
]


def gzip_response(
    packed: BinaryIO,
    media_type: str,
    accept_encoding: str,
    headers: Mapping[str, str] | None = None,
) -> StreamingResponse:
    """Return an answer stored in gzip, decompressed for clients that do not accept gzip.

    Of the body, packed or not, a piece at a time is in memory.

    Parameters
    ----------
    packed
        A file of one gzip member of less than 4 GiB, which is closed in the end.
    media_type
        Media type of the decompressed body.
    accept_encoding
        The request's header ``Accept-Encoding``.
    headers
        Further headers.
    """
    every = {"Vary": "Accept-Encoding", **(headers or {})}
    if takes_gzip(accept_encoding):
        return file_response(packed, media_type, every | {"Content-Encoding": "gzip"})
    size = _unpacked_size(packed)
    return pieces_response(unpacked(packed), size, packed, media_type, every)


def unpacked(packed: BinaryIO) -> Iterator[bytes]:
    """Iterate over the content of a file in gzip, a piece at a time."""
    # The mode is given because that of a temporary file says that it can be written.
    return pieces(cast(BinaryIO, gzip.GzipFile(fileobj=packed, mode="rb")))


def _unpacked_size(packed: BinaryIO) -> int:
    # The last field of a gzip member (RFC 1952, section 2.3.1).
    packed.seek(-4, os.SEEK_END)
    size = int.from_bytes(packed.read(4), "little")
    packed.seek(0)
    return size


def takes_gzip(accept_encoding: str) -> bool:
    """Return whether a header ``Accept-Encoding`` accepts gzip."""
    for entry in accept_encoding.lower().split(","):
        coding, *parameters = (part.replace(" ", "") for part in entry.split(";"))
        if coding in ("gzip", "x-gzip"):
            return not any(_REFUSED.fullmatch(parameter) for parameter in parameters)
    return False


def strong_etag(version: str) -> str:
    """Return the entity tag of a version whose body has the same bytes for all clients."""
    return f'"{version}"'


def weak_etag(version: str) -> str:
    """Return the entity tag of a version, weak as bodies with and without gzip share it."""
    return f'W/"{version}"'


def etag_matches(if_none_match: str | None, etag: str) -> bool:
    """Return whether a header ``If-None-Match`` lists an entity tag, compared weakly."""
    tags = [tag.strip().removeprefix("W/") for tag in (if_none_match or "").split(",")]
    return "*" in tags or etag.removeprefix("W/") in tags
