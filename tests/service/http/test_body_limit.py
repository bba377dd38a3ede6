"""Large bodies are parsed one after the other; uploads wait until there is space for them."""

import asyncio
from contextlib import suppress

from starlette.types import Message, Receive, Scope, Send

from service.http import BodyLimit
from service.http.body_limit import FORM_OVERHEAD, LARGE_BYTES, LARGEST_UPLOADS, BodyRefused

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


class Uploads:
    """Requests with uploads of the greatest size, whose bodies are kept for a while.

    Parameters
    ----------
    patience
        Seconds that one waits for space.
    ends_with_body
        Whether the body is gone long before the answer.
    """

    def __init__(self, patience: float, ends_with_body: bool = False) -> None:
        self.limited = BodyLimit(self._application, 1, MEGABYTE, ("/upload",), patience)
        self.kept, self.most = 0, 0
        self.answered = asyncio.Event()
        self._ends_with_body = ends_with_body

    async def _application(self, scope: Scope, receive: Receive, send: Send) -> None:
        await receive()
        self.kept += 1
        self.most = max(self.most, self.kept)
        await asyncio.sleep(0.01)
        self.kept -= 1
        if self._ends_with_body:
            scope["state"]["give_back_space"]()
        await self.answered.wait()

    async def send(self) -> list[Message]:
        """Send one, and return what is answered by the middleware itself."""
        sent: list[Message] = []

        async def received() -> Message:
            return {"type": "http.request", "body": b"", "more_body": False}

        async def answer(message: Message) -> None:
            sent.append(message)

        headers = [(b"content-length", str(MEGABYTE + FORM_OVERHEAD).encode())]
        scope = {"type": "http", "path": "/upload", "headers": headers}
        # FastAPI answers it, which is dropped for the answer of the middleware.
        with suppress(BodyRefused):
            await self.limited(scope, received, answer)
        return sent


def test_uploads_wait_for_space() -> None:
    async def all_sent(uploads: Uploads) -> None:
        uploads.answered.set()
        await asyncio.gather(*(uploads.send() for _ in range(2 * LARGEST_UPLOADS + 1)))

    uploads = Uploads(patience=60.0)
    asyncio.run(all_sent(uploads))
    assert uploads.most == LARGEST_UPLOADS


def test_uploads_for_which_there_is_no_space_are_refused() -> None:
    async def answers() -> list[list[Message]]:
        uploads = Uploads(patience=0.1)
        sending = [asyncio.create_task(uploads.send()) for _ in range(LARGEST_UPLOADS + 1)]
        await sending[-1]
        uploads.answered.set()
        return list(await asyncio.gather(*sending))

    *taken, refused = asyncio.run(answers())
    assert taken == [[]] * LARGEST_UPLOADS
    assert refused[0]["status"] == 503
    assert (b"retry-after", b"10") in refused[0]["headers"]


def test_uploads_that_are_validated_take_no_space() -> None:
    async def all_sent(uploads: Uploads) -> None:
        count = 2 * LARGEST_UPLOADS
        sending = [asyncio.create_task(uploads.send()) for _ in range(count)]
        await asyncio.sleep(0.5)
        uploads.answered.set()
        assert await asyncio.gather(*sending) == [[]] * count

    asyncio.run(all_sent(Uploads(patience=0.3, ends_with_body=True)))
