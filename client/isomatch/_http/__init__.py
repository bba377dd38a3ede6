"""HTTP: steps of operations and their answers without I/O, and the two transports that do I/O."""

from isomatch._http.address import DEFAULT_URL, URL_VARIABLE, api_key_or_default, url_or_default
from isomatch._http.answers import (
    checked_stream,
    delete,
    fetch,
    fetch_bytes,
    parsed,
    send,
    unexpected,
)
from isomatch._http.async_transport import AsyncTransport
from isomatch._http.blocking_transport import BlockingTransport
from isomatch._http.events import EventReader
from isomatch._http.limits import retries_given, timeout_given, wait_given
from isomatch._http.operation import (
    Call,
    Item,
    Json,
    Listen,
    NextLine,
    Operation,
    Pause,
    Stream,
    UploadFile,
)
from isomatch._http.retries import (
    BUSY,
    LONGEST_OUTAGE,
    LONGEST_PAUSE,
    Failures,
    failure_message,
    retry_after,
    with_retries,
)

__all__ = [
    "BUSY",
    "DEFAULT_URL",
    "LONGEST_OUTAGE",
    "LONGEST_PAUSE",
    "URL_VARIABLE",
    "AsyncTransport",
    "BlockingTransport",
    "Call",
    "EventReader",
    "Failures",
    "Item",
    "Json",
    "Listen",
    "NextLine",
    "Operation",
    "Pause",
    "Stream",
    "UploadFile",
    "api_key_or_default",
    "checked_stream",
    "delete",
    "failure_message",
    "fetch",
    "fetch_bytes",
    "parsed",
    "retries_given",
    "retry_after",
    "send",
    "timeout_given",
    "unexpected",
    "url_or_default",
    "wait_given",
    "with_retries",
]
