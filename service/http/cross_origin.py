"""Web pages of other sites that may call the API: cross-origin resource sharing (CORS)."""

import re
from collections.abc import Collection
from typing import Annotated, Final, TypeAlias

from pydantic import BeforeValidator
from pydantic_settings import NoDecode
from starlette.middleware.cors import CORSMiddleware
from starlette.types import ASGIApp, Receive, Scope, Send

from service.http.request_context import REQUEST_ID
from service.http.security import KeyRing, protected

_ORIGIN: Final = re.compile(r"https?://[a-z0-9.-]+(:\d{1,5})?")

_REQUEST_HEADERS: Final = (
    "Authorization",
    "Content-Type",
    "Idempotency-Key",
    "If-None-Match",
    "Last-Event-ID",
    "traceparent",
    REQUEST_ID,
)
_RESPONSE_HEADERS: Final = (
    "Content-Disposition",
    "ETag",
    "Idempotency-Replayed",
    "Location",
    "Retry-After",
    REQUEST_ID,
)


def read_origins(listing: object) -> object:
    """Read origins, separated by commas or white space.

    Raises
    ------
    ValueError
        One of them is no origin.
    """
    if not isinstance(listing, str):
        return listing
    origins = tuple(one.lower() for one in re.split(r"[,\s]+", listing) if one)
    for origin in origins:
        if not _ORIGIN.fullmatch(origin):
            raise ValueError(f"{origin} is not an origin; write scheme, host and port, if any")
    return origins


Origins: TypeAlias = Annotated[tuple[str, ...], NoDecode, BeforeValidator(read_origins)]
"""Origins of web pages, such as ``https://app.example.org``."""


class CrossOrigin:
    """ASGI middleware that lets pages of some origins call what is under ``/v1``, with a key.

    Browsers ask first, without a key, so that it comes before authentication. Where no key is
    needed it does nothing: what a page may read then, every visitor of the page gives it.

    Parameters
    ----------
    app
        The application.
    keys
        The accepted keys.
    origins
        Origins of the pages.
    """

    def __init__(self, app: ASGIApp, keys: KeyRing, origins: Collection[str]) -> None:
        self._app = app
        self._keys = keys
        self._shared = CORSMiddleware(
            app,
            allow_origins=origins,
            allow_methods=("GET", "HEAD", "POST", "DELETE"),
            allow_headers=_REQUEST_HEADERS,
            expose_headers=_RESPONSE_HEADERS,
        )

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer that of a browser whether it may be made."""
        shared = scope["type"] == "http" and protected(scope["path"]) and self._keys.needed
        await (self._shared if shared else self._app)(scope, receive, send)
