"""Content negotiation of gzip, and conditional requests (RFC 9110, sections 12.5.3 and 13.1.2)."""

import gzip
import re
from collections.abc import Mapping
from typing import Annotated, Final

from fastapi import Header, Response

_REFUSED: Final = re.compile(r"q=0(\.0{0,3})?")

AcceptEncoding = Annotated[str, Header(include_in_schema=False)]


def gzip_response(
    packed: bytes, media_type: str, accept_encoding: str, headers: Mapping[str, str] | None = None
) -> Response:
    """Return an answer stored in gzip, decompressed for clients that do not accept gzip.

    Parameters
    ----------
    packed
        The body in gzip.
    media_type
        Media type of the decompressed body.
    accept_encoding
        The request's header ``Accept-Encoding``.
    headers
        Further headers.
    """
    every = {"Vary": "Accept-Encoding", **(headers or {})}
    if _takes_gzip(accept_encoding):
        return Response(packed, media_type=media_type, headers=every | {"Content-Encoding": "gzip"})
    return Response(gzip.decompress(packed), media_type=media_type, headers=every)


def _takes_gzip(accept_encoding: str) -> bool:
    for entry in accept_encoding.lower().split(","):
        coding, *parameters = (part.replace(" ", "") for part in entry.split(";"))
        if coding in ("gzip", "x-gzip"):
            return not any(_REFUSED.fullmatch(parameter) for parameter in parameters)
    return False


def weak_etag(version: str) -> str:
    """Return the entity tag of a version, weak as bodies with and without gzip share it."""
    return f'W/"{version}"'


def etag_matches(if_none_match: str, etag: str) -> bool:
    """Return whether a header ``If-None-Match`` lists an entity tag, compared weakly."""
    tags = [tag.strip().removeprefix("W/") for tag in if_none_match.split(",")]
    return "*" in tags or etag.removeprefix("W/") in tags
