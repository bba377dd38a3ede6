"""A receiver of webhooks: a real server on the loopback interface that answers as it is told."""

import ssl
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

from tests.waiting import until


@dataclass(frozen=True)
class Received:
    """A request as it came in."""

    path: str
    headers: dict[str, str]
    body: bytes
    when: float


@dataclass
class Receiver:
    """A running receiver.

    Attributes
    ----------
    answers
        Statuses of its next answers; then it takes everything. ``None`` closes the connection
        without one.
    received
        What came in, in order.
    pause
        Seconds between the letters of its answer.
    """

    port: int = 0
    answers: list[int | None] = field(default_factory=list)
    received: list[Received] = field(default_factory=list)
    pause: float = 0.0

    def wait(self, count: int, seconds: float = 240.0) -> list[Received]:
        """Wait until so many requests came in."""
        until(lambda: len(self.received) >= count, seconds, pause=0.01)
        return self.received


@contextmanager
def receiving(context: ssl.SSLContext | None = None) -> Iterator[Receiver]:
    """Run a receiver, over TLS if a context is given."""
    receiver = Receiver()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["content-length"]))
            headers = {name.lower(): value for name, value in self.headers.items()}
            receiver.received.append(Received(self.path, headers, body, time.time()))
            status = receiver.answers.pop(0) if receiver.answers else 204
            if status is None:
                return
            answer = f"HTTP/1.1 {status} x\r\nLocation: /elsewhere\r\nContent-Length: 0\r\n\r\n"
            for letter in answer if receiver.pause else [answer]:
                time.sleep(receiver.pause)
                try:
                    self.wfile.write(letter.encode())
                except OSError:
                    return

        def log_message(self, *_: object) -> None:
            pass

    class Server(ThreadingHTTPServer):
        daemon_threads = True

        def handle_error(self, *_: object) -> None:
            pass

    with Server(("127.0.0.1", 0), Handler) as server:
        if context is not None:
            server.socket = context.wrap_socket(server.socket, server_side=True)
        receiver.port = server.server_address[1]
        thread = Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        try:
            yield receiver
        finally:
            server.shutdown()
            thread.join()
