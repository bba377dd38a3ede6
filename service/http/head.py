"""HEAD, answered wherever GET is: with the same headers, and no body.

Load balancers, caches and download tools ask so. What would be long to make only to be thrown away,
a picture or a stream of events, is not made.
"""

from typing import Final

from starlette.requests import HTTPConnection
from starlette.routing import BaseRoute, Match
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_HEAD: Final = "isomatch.head"


def body_wanted(request: HTTPConnection) -> bool:
    """Whether the body of an answer to a GET is sent at all."""
    return _HEAD not in request.scope


class HeadLikeGet:
    """Passes HEAD on as GET, and leaves the body of the answer out.

    Parameters
    ----------
    app
        The application.
    routes
        Its routes: where none of them answers GET, there is nothing to be answered.
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
                scope["route"] = asked["route"]  # requests are measured by it
            await send(message)

        await self._app(asked, receive, without_body)
