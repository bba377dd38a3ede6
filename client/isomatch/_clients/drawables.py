"""Shapes that results request when they are drawn."""

from isomatch._http import AsyncTransport, BlockingTransport
from isomatch._operations.results import get_drawable
from isomatch._results import DrawableSource, Result


def with_drawables(result: Result, transport: BlockingTransport | AsyncTransport) -> Result:
    """Let a result of a blocking client request the shapes that it is drawn with.

    One of an asynchronous client would block the event loop.
    """
    if isinstance(transport, BlockingTransport):
        result._drawables = DrawableSource(lambda drawn_id: transport.run(get_drawable(drawn_id)))
    return result
