"""HTTP: one exchange of request and answer without I/O, and the two transports that do the I/O."""

from isomatch._http.address import DEFAULT_URL, URL_VARIABLE, address, key
from isomatch._http.async_transport import AsyncTransport
from isomatch._http.events import EventReader
from isomatch._http.exchange import (
    LONGEST_PAUSE,
    Call,
    Heard,
    Json,
    Listen,
    NextLine,
    Operation,
    Pause,
    Stream,
    back_off,
    checked,
    describe,
    parsed,
    send,
    unexpected,
)
from isomatch._http.transport import BlockingTransport

__all__ = [
    "DEFAULT_URL",
    "LONGEST_PAUSE",
    "URL_VARIABLE",
    "AsyncTransport",
    "BlockingTransport",
    "Call",
    "EventReader",
    "Heard",
    "Json",
    "Listen",
    "NextLine",
    "Operation",
    "Pause",
    "Stream",
    "address",
    "back_off",
    "checked",
    "describe",
    "key",
    "parsed",
    "send",
    "unexpected",
]
