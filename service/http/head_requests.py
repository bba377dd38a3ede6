"""HEAD requests, answered wherever GET is, with the same headers and without a body.

Load balancers, caches and download tools send them. Bodies that take long to make, pictures and
event streams, are not made for them.
"""

from typing import Final

from starlette.requests import HTTPConnection
from starlette.routing import BaseRoute, Match
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_HEAD: Final = "isomatch.head"


def body_wanted(request: HTTPConnection) -> bool:
    """Return whether the body is sent: not for a HEAD request passed on as GET."""
    return _HEAD not in request.scope


class HeadLikeGet:
    """ASGI middleware that passes HEAD on as GET and drops the body of the answer.

    Parameters
    ----------
    app
        The application.
    routes
        Its routes; HEAD is passed on as GET where one of them answers GET.
    """

    def __init__(self, app: ASGIApp, routes: list[BaseRoute]) -> None:
        self._app = app
        self._routes = routes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self._app(scope, receive, send)
            return
        asked = {**scope, "method": "GET", _HEAD: True}
        if not any(route.matches(asked)[0] is Match.FULL for route in self._routes):
            await self._app(scope, receive, send)
            return

        async def without_body(message: Message) -> None:
            if message["type"] == "http.response.body":
                message = {**message, "body": b""}
            elif "route" in asked:
                scope["route"] = asked["route"]  # the label of the request's metrics
            await send(message)

        await self._app(asked, receive, without_body)
