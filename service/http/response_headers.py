"""Middleware that sets the security headers of answers in one place."""

from typing import Final

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.http.security import protected

_DOCUMENTATION: Final = ("/docs", "/redoc")

_DOCUMENTATION_POLICY: Final = "; ".join(
    (
        "default-src 'none'",
        # Their HTML, which is FastAPI's and shows nothing that was uploaded, has inline scripts.
        "script-src 'self' 'unsafe-inline'",
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data:",
        "connect-src 'self'",
        # ReDoc's search.
        "worker-src blob:",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
"""Content-Security-Policy of Swagger UI and ReDoc."""


class ResponseHeaders:
    """ASGI middleware that sets security headers where the application has set none.

    Everything has ``X-Content-Type-Options``. What is under ``/v1`` belongs to a tenant, and is not
    stored by caches. The documentation has a Content-Security-Policy; the page sets its own.

    Parameters
    ----------
    app
        The application.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        defaults = _defaults(scope["path"])

        async def completed(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in defaults.items():
                    headers.setdefault(name, value)
            await send(message)

        await self._app(scope, receive, completed)


def _defaults(path: str) -> dict[str, str]:
    headers = {"X-Content-Type-Options": "nosniff"}
    if protected(path):
        headers["Cache-Control"] = "private, no-store"
    if path.startswith(_DOCUMENTATION):
        headers["Content-Security-Policy"] = _DOCUMENTATION_POLICY
    return headers
