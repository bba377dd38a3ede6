"""Answers that are kept in gzip, and answers that the client has already."""

import gzip
import re
from collections.abc import Mapping
from typing import Annotated, Final

from fastapi import Header, Response

_REFUSED: Final = re.compile(r"q=0(\.0{0,3})?")

AcceptEncoding = Annotated[str, Header(include_in_schema=False)]


def unpacked_if_need_be(
    packed: bytes, media_type: str, accept_encoding: str, headers: Mapping[str, str] | None = None
) -> Response:
    """Return an answer kept in gzip, unpacked for those who do not take that.

    Parameters
    ----------
    packed
        Its body in gzip.
    media_type
        What it is once unpacked.
    accept_encoding
        What the client takes, as its header says.
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


def names(if_none_match: str, etag: str) -> bool:
    """Whether a header ``If-None-Match`` names an entity tag."""
    tags = [tag.strip().removeprefix("W/") for tag in if_none_match.split(",")]
    return "*" in tags or etag in tags
