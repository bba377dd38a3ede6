"""Connections on which no whole request comes."""

import contextlib
import json
import logging
import socket
from urllib.parse import urlsplit

import pytest

from service.standalone import EmbeddedServer
from tests.service.conftest import Api, Json, idle_api

PATIENCES = (0.2, 2.0, 20.0)
"""Seconds; where this process was kept waiting for as long itself, the next is tried."""

WHOLE = b"GET /health/live HTTP/1.1\r\nHost: x\r\n\r\n"


def connected(api: Api) -> socket.socket:
    address = urlsplit(api.url)
    assert address.hostname is not None
    return socket.create_connection((address.hostname, address.port), timeout=60)


def until_closed(connection: socket.socket) -> bytes:
    return b"".join(iter(lambda: connection.recv(65536), b""))


def refusal(answer: bytes) -> tuple[bytes, Json]:
    head, _, body = answer.partition(b"\r\n\r\n")
    lines = head.lower().split(b"\r\n")
    assert b"content-type: application/problem+json" in lines
    assert b"connection: close" in lines
    assert any(line.startswith(b"x-request-id: ") for line in lines)
    assert f"content-length: {len(body)}".encode() in lines
    document: Json = json.loads(body)
    assert f" {document['status']} ".encode() in lines[0]
    return lines[0], document


def answered(connection: socket.socket) -> bytes:
    answer = b""
    while b'{"status":"ok"}' not in answer:
        piece = connection.recv(65536)
        if not piece:
            raise ConnectionError(answer)
        answer += piece
    return answer


def given_up(server: EmbeddedServer, *pieces: bytes) -> Json:
    """Send pieces, waiting for the answer to each whole request, and be given up."""
    for patience in PATIENCES:
        with idle_api(server, body_patience=patience) as api, connected(api) as connection:
            try:
                for piece in pieces:
                    connection.sendall(piece)
                    if piece == WHOLE:
                        assert answered(connection).startswith(b"HTTP/1.1 200")
                answer = until_closed(connection)
            except ConnectionError:
                continue
            if answer:
                line, document = refusal(answer)
                assert b" 408 " in line
                assert f"within {patience:g} seconds" in document["detail"]
                return document
    raise AssertionError("no answer, however patient")


@pytest.mark.parametrize("begun", [b"", WHOLE[:9], WHOLE[:-2], WHOLE[:-2] + b"A: b\r\n"])
def test_who_sends_no_head_is_given_up(server: EmbeddedServer, begun: bytes) -> None:
    assert given_up(server, begun)["type"] == "urn:isomatch:problem:head-stalled"


def test_a_second_request_has_its_time_too(server: EmbeddedServer) -> None:
    document = given_up(server, WHOLE, WHOLE[:20])
    assert document["type"] == "urn:isomatch:problem:head-stalled"


def test_a_head_may_come_in_pieces_but_not_for_ever(server: EmbeddedServer) -> None:
    """One byte after the other, which no pause between two pieces would end."""
    with idle_api(server, body_patience=PATIENCES[0]) as api, connected(api) as connection:
        connection.sendall(WHOLE[:-2] + b"Endless: ")
        connection.settimeout(PATIENCES[0] / 20)
        # The answer may be lost where the connection is closed while we are sending.
        with contextlib.suppress(ConnectionError):
            while True:
                connection.sendall(b"x")
                with contextlib.suppress(TimeoutError):
                    assert b" 408 " in connection.recv(65536)
                    break


def test_heads_in_pieces_are_read(server: EmbeddedServer) -> None:
    with idle_api(server) as api, connected(api) as connection:
        for piece in (WHOLE[:7], WHOLE[7:-1], WHOLE[-1:]):
            connection.sendall(piece)
        assert answered(connection).startswith(b"HTTP/1.1 200")


@pytest.mark.parametrize(
    "sent", [b"\x16\x03\x01 hello\r\n\r\n", b"GET\r\n\r\n", WHOLE[:-4] + b"\x00\r\n\r\n"]
)
def test_what_is_no_http_is_refused_like_everything_else(
    server: EmbeddedServer, sent: bytes
) -> None:
    with idle_api(server) as api, connected(api) as connection:
        connection.sendall(sent)
        line, document = refusal(until_closed(connection))
    assert b" 400 " in line
    assert document["type"] == "urn:isomatch:problem:bad-request"


@pytest.mark.parametrize("method", [b"GET", b"HEAD", b"POST"])
def test_a_body_that_is_no_http_is_the_callers_fault(
    server: EmbeddedServer, caplog: pytest.LogCaptureFixture, method: bytes
) -> None:
    """Told so, and that alone: what the service answers as well is not sent."""
    request = WHOLE[:-2].replace(b"GET", method) + b"Transfer-Encoding: chunked\r\n\r\nno size\r\n"
    with idle_api(server) as api, connected(api) as connection:
        connection.sendall(request)
        answer = until_closed(connection)
    assert [entry.message for entry in caplog.records if entry.levelno >= logging.ERROR] == []
    assert answer.startswith(b"HTTP/1.1 400 ")
    assert answer.count(b"HTTP/1.1") == 1
    assert answer.endswith(b"\r\n\r\n") == (method == b"HEAD")


def test_what_is_answered_before_its_end_may_not_take_for_ever(server: EmbeddedServer) -> None:
    begun = b"POST /v1/nothing HTTP/1.1\r\nHost: x\r\nContent-Length: 9\r\n\r\n1"
    for patience in PATIENCES:
        answer = b""
        with (
            idle_api(server, body_patience=patience) as api,
            connected(api) as connection,
            contextlib.suppress(ConnectionError),
        ):
            connection.sendall(begun)
            answer = connection.recv(65536)
            # What comes after the answer is read on, so that another request can follow.
            connection.sendall(b"2")
            until_closed(connection)
        # Given up before the head was sent, it is tried again.
        if answer and not answer.startswith(b"HTTP/1.1 408 "):
            break
    assert answer.startswith(b"HTTP/1.1 404 ")


def test_no_other_protocol_is_spoken_and_nobody_is_told_to_install_one(
    server: EmbeddedServer, caplog: pytest.LogCaptureFixture
) -> None:
    wish = b"Connection: upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Key: x\r\n\r\n"
    with idle_api(server) as api, connected(api) as connection:
        connection.sendall(WHOLE[:-2] + wish)
        assert answered(connection).startswith(b"HTTP/1.1 200")
    assert "upgrade" not in caplog.text.lower()
