"""Large bodies are parsed one after the other, and waited for together."""

import asyncio

from starlette.types import Message, Receive, Scope, Send

from service.http import BodyLimit
from service.http.body_limit import LARGE_BYTES

MEGABYTE = 1024**2


async def parsed(count: int) -> list[str]:
    """What several requests with large bodies do, all sent at once, in order.

    Each parses its body, then waits until all have done so.
    """
    barrier, done = asyncio.Barrier(count), list[str]()

    async def application(scope: Scope, receive: Receive, send: Send) -> None:
        message = await receive()
        done.append(f"{scope['path']} parses {len(message['body'])}")
        await barrier.wait()
        done.append(f"{scope['path']} answers")

    async def received() -> Message:
        return {"type": "http.request", "body": b" " * (LARGE_BYTES + 1), "more_body": False}

    async def sent(message: Message) -> None:
        raise AssertionError(f"nothing is to be sent, but {message}")

    limited = BodyLimit(application, MEGABYTE, MEGABYTE, (), patience=60.0)
    headers = [(b"content-length", str(LARGE_BYTES + 1).encode())]
    scopes = [{"type": "http", "path": f"/{n}", "headers": headers} for n in range(count)]
    async with asyncio.timeout(60.0):
        await asyncio.gather(*(limited(one, received, sent) for one in scopes))
    return done


def test_requests_with_large_bodies_do_not_wait_for_the_answers_of_others() -> None:
    done = asyncio.run(parsed(4))
    assert done[:4] == [f"/{n} parses {LARGE_BYTES + 1}" for n in range(4)]
    assert sorted(done[4:]) == [f"/{n} answers" for n in range(4)]
