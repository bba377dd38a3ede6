"""Replies of Redis as the types they have here (its own types allow for text as well)."""

from typing import overload


@overload
def blob(reply: bytes | str) -> bytes: ...
@overload
def blob(reply: None) -> None: ...
@overload
def blob(reply: bytes | str | None) -> bytes | None: ...
def blob(reply: bytes | str | None) -> bytes | None:
    """Return a reply as bytes."""
    return reply.encode() if isinstance(reply, str) else reply


@overload
def text(reply: bytes | str) -> str: ...
@overload
def text(reply: None) -> None: ...
@overload
def text(reply: bytes | str | None) -> str | None: ...
def text(reply: bytes | str | None) -> str | None:
    """Return a reply as text."""
    return reply.decode() if isinstance(reply, bytes) else reply
