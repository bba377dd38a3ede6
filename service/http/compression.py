"""Middleware that compresses answers which are text: JSON, CSV and OBJ."""

from typing import Final

from starlette.datastructures import Headers
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES, GZipMiddleware
from starlette.types import ASGIApp, Receive, Scope, Send

from service.http.negotiation import takes_gzip

_AS_THEY_ARE: Final = (
    *DEFAULT_EXCLUDED_CONTENT_TYPES,
    "application/octet-stream",
    "model/gltf-binary",
    "model/ply",
)
"""Media types that hardly become shorter, and event streams."""

_LEAST: Final = 1024
"""Bytes from which on an answer is compressed."""


class Compression:
    """ASGI middleware that compresses text for clients that accept gzip, if it is not yet.

    Parameters
    ----------
    app
        The application.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._compressed = GZipMiddleware(
            app, minimum_size=_LEAST, compresslevel=6, exclude_content_types=_AS_THEY_ARE
        )

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        # Starlette's would compress also where gzip is refused by `q=0`.
        accepted = scope["type"] == "http" and takes_gzip(
            Headers(scope=scope).get("accept-encoding", "")
        )
        await (self._compressed if accepted else self._app)(scope, receive, send)
