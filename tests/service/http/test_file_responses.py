"""Files are closed, whether they are sent or not."""

import io

import anyio
import pytest
from starlette.types import Message

from service.http import file_response


@pytest.mark.parametrize("leaves", [False, True])
def test_files_are_closed(leaves: bool) -> None:
    """A client that leaves at once asks for no piece of the file."""
    file = io.BytesIO(b"content")
    sent: list[bytes] = []

    async def receive() -> Message:
        if not leaves:
            await anyio.sleep_forever()
        return {"type": "http.disconnect"}

    async def send(message: Message) -> None:
        if leaves:
            await anyio.sleep_forever()
        sent.append(message.get("body", b""))

    scope = {"type": "http", "asgi": {"spec_version": "2.3"}}
    anyio.run(file_response(file, "text/plain"), scope, receive, send)
    assert file.closed
    assert b"".join(sent) == (b"" if leaves else b"content")
