"""``/`` and ``/page``: the files of the page, whose scripts use the API under ``/v1``."""

import io
from pathlib import PurePosixPath
from typing import Final

from fastapi import APIRouter, Response

from service.http import AcceptEncoding, IfNoneMatch, NotFound, etag_matches, gzip_response
from service.page.files import PLOTLY, page_file

router = APIRouter(include_in_schema=False)

POLICY: Final = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        # plotly.js sets empty style attributes; this is the hash of the empty string.
        "style-src-attr 'unsafe-hashes' 'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='",
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
"""Content-Security-Policy: no resources of other hosts, no inline scripts or styles."""

_HEADERS: Final = {
    "Content-Security-Policy": POLICY,
    "Referrer-Policy": "no-referrer",
}
_DAY: Final = 86400
"""Seconds."""


@router.get("/")
def index(accept_encoding: AcceptEncoding = "", if_none_match: IfNoneMatch = None) -> Response:
    """Return the page."""
    return _answer("index.html", accept_encoding, if_none_match)


@router.get("/page/{path:path}")
def part(
    path: str, accept_encoding: AcceptEncoding = "", if_none_match: IfNoneMatch = None
) -> Response:
    """Return a file of the page."""
    return _answer(path, accept_encoding, if_none_match)


def _answer(path: str, accept_encoding: str, if_none_match: str | None) -> Response:
    file = page_file(PurePosixPath(path))
    if file is None:
        raise NotFound(f"The page has no file {path!r}.")
    # Our files must all be of one version; plotly.js is large and changes rarely.
    caching = f"public, max-age={_DAY}" if path == PLOTLY else "no-cache"
    headers = {**_HEADERS, "ETag": file.etag, "Cache-Control": caching, "Vary": "Accept-Encoding"}
    if etag_matches(if_none_match, file.etag):
        return Response(status_code=304, headers=headers)
    return gzip_response(io.BytesIO(file.packed), file.media_type, accept_encoding, headers)
