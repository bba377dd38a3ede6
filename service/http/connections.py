"""Connections on which no request comes: too slow a head, or what is no HTTP."""

import asyncio
from typing import Any, Final
from uuid import uuid4

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from service.http.middleware import REQUEST_ID
from service.http.problem_documents import MEDIA_TYPE
from service.http.problems import ApiProblem, BadRequest, HeadStalled

_UNANSWERED: Final = (h11.IDLE, h11.SEND_RESPONSE)


class Connection(H11Protocol):
    """A connection that is closed when the head of a request does not come in.

    Uvicorn bounds how long a connection may lie idle between requests, but waits for ever for a
    first request, for the rest of a head, and for that of a body that was answered already. What
    is no HTTP is refused like everything else, with a problem document.

    Parameters
    ----------
    arguments
        As Uvicorn makes a connection; its state has the service, whose `body_patience` holds for a
        whole head, and between two pieces of such a body.
    """

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._patience: float = self.app_state["service"].settings.body_patience
        self._waiting: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a first head."""
        super().connection_made(transport)
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing more."""
        self._wait_no_more()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Read on, and see whether that was the end of a head or the beginning of the next."""
        begun = self.conn.their_state is h11.IDLE
        super().data_received(data)
        heading = self.conn.their_state is h11.IDLE
        # The service, which bounds how long a body takes, reads none that it has answered.
        unread = self.conn.their_state is h11.SEND_BODY and self.conn.our_state is h11.DONE
        if not (begun and heading):
            self._wait_no_more()
        if (heading or unread) and self._waiting is None:
            self._wait()

    def send_400_response(self, msg: str) -> None:
        """Refuse what is no HTTP."""
        self._refuse(BadRequest(f"{msg} See RFC 9112, or let a library write requests."))

    def _should_upgrade(self) -> bool:
        """Speak no other protocol, and answer as if none was asked for (RFC 9110, 7.8)."""
        return False

    def _wait(self) -> None:
        self._waiting = self.loop.call_later(self._patience, self._give_up)

    def _wait_no_more(self) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None

    def _give_up(self) -> None:
        self._waiting = None
        said = f"The head of the request did not come within {self._patience:g} seconds."
        self._refuse(HeadStalled(said))

    def _refuse(self, problem: ApiProblem) -> None:
        # While an answer is on its way none can be begun: then that is broken off.
        if self.conn.our_state in _UNANSWERED and not self.transport.is_closing():
            body = problem.problem().model_dump_json().encode()
            headers = {
                "content-type": MEDIA_TYPE,
                "content-length": str(len(body)),
                "connection": "close",
                REQUEST_ID: uuid4().hex,
            }
            if self.conn.our_state is h11.SEND_RESPONSE and self.scope["method"] == "HEAD":
                body = b""
            head = h11.Response(status_code=problem.status, headers=list(headers.items()))
            for event in (head, h11.Data(data=body), h11.EndOfMessage()):
                self.transport.write(self.conn.send(event) or b"")
        if self.cycle is not None:
            self.cycle.disconnected = True  # whatever the service answers is not sent any more
        self.transport.close()
