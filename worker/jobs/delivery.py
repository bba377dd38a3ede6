"""One attempt to deliver a webhook: signed, and to a permitted address only.

The name of the receiver is resolved once, its addresses are checked, and the connection is made to
one of them, so DNS rebinding has no effect. Redirects are not followed and proxies of the
environment not used, because both would connect to addresses that were not checked.
"""

import contextlib
import hashlib
import hmac
import http.client
import socket
import ssl
import time
from concurrent.futures import Future
from dataclasses import dataclass
from datetime import UTC, datetime
from http import HTTPStatus
from threading import Thread
from typing import Final
from urllib.parse import SplitResult, urlsplit

from broker.contracts import (
    Delivery,
    DeliveryPayload,
    DeliveryState,
    JobRecord,
    MatchSummary,
    Summary,
    Webhook,
    WebhookEvent,
)
from broker.telemetry import logger
from broker.webhooks import WebhookSettings, permitted, retry_delay
from worker.jobs.context import JobContext
from worker.jobs.failures import NotDelivered

SIGNATURE: Final = "Isomatch-Signature"
_PORTS: Final = {"http": 80, "https": 443}
_MOST_ADDRESSES: Final = 4
"""Addresses of a receiver that are tried."""

_MAX_ERROR_LENGTH: Final = 200
"""Characters."""

log = logger("isomatch.webhooks")


class ReceiverNotPermitted(Exception):
    """No address of the receiver is permitted; there are no further attempts."""


@dataclass(frozen=True)
class Outcome:
    """Outcome of one attempt.

    Parameters
    ----------
    status
        HTTP status of the response; None without a response.
    error
        Reason of the failure; None for a success.
    final
        Whether there are no further attempts.
    """

    status: int | None = None
    error: str | None = None
    final: bool = False


def deliver(payload: DeliveryPayload, context: JobContext) -> None:
    """Try once to deliver a webhook, and record the outcome.

    Raises
    ------
    NotDelivered
        The receiver did not accept it.
    """
    store, settings = context.store, context.webhooks
    record = store.jobs.get(payload.job)
    if record is None or record.webhook is None or not _is_due(record):
        store.webhooks.remove(payload.job)
        return
    (summary,) = store.results.summaries([record.id])
    body = _body(record, summary)
    outcome = post(record.webhook, body, _headers(record, payload.attempt), settings)
    delivery = _delivery(outcome, payload.attempt, settings)
    store.webhooks.record(record.id, delivery)
    log.info("webhook", state=delivery.state.value, attempt=payload.attempt, status=outcome.status)
    if outcome.error is not None:
        raise NotDelivered(outcome.error)


def sign(body: bytes, secret: str, timestamp: int) -> str:
    """Return the signature of a body: ``t=TIME,v1=HEX``, the HMAC-SHA256 of ``TIME.BODY``.

    Parameters
    ----------
    body
        Body of the request.
    secret
        Shared with the receiver.
    timestamp
        Seconds since 1970, so that a receiver can refuse old requests.
    """
    signed = f"{timestamp}.".encode() + body
    digest = hmac.new(secret.encode(), signed, hashlib.sha256).hexdigest()
    return f"t={timestamp},v1={digest}"


def post(
    webhook: Webhook, body: bytes, headers: dict[str, str], settings: WebhookSettings
) -> Outcome:
    """Send a body to a receiver and return the outcome; raise nothing."""
    if webhook.secret is not None:
        headers = headers | {SIGNATURE: sign(body, webhook.secret, int(time.time()))}
    try:
        status = _status_in_time(urlsplit(webhook.url), body, headers, settings)
    except ReceiverNotPermitted as error:
        return Outcome(error=str(error), final=True)
    except (OSError, UnicodeError) as error:
        return Outcome(error=(str(error) or type(error).__name__)[:_MAX_ERROR_LENGTH])
    except http.client.HTTPException as error:
        # Its message would quote the receiver's bytes.
        return Outcome(error=f"the receiver's answer is no HTTP ({type(error).__name__})")
    if 200 <= status < 300:
        return Outcome(status)
    redirected = "; redirects are not followed" if 300 <= status < 400 else ""
    return Outcome(
        status, f"the receiver answered {status}{redirected}", final=status == HTTPStatus.GONE
    )


def _status_in_time(
    url: SplitResult, body: bytes, headers: dict[str, str], settings: WebhookSettings
) -> int:
    """Return the status of the answer, with one deadline for DNS, connection and answer.

    Resolvers have no timeout, and that of a socket starts again with each byte received.
    """
    status: Future[int] = Future()

    def ask() -> None:
        try:
            status.set_result(_status(url, body, headers, settings))
        except BaseException as error:
            status.set_exception(error)

    # A daemon: the process, which is that of this job, ends without it.
    Thread(target=ask, name="webhook", daemon=True).start()
    seconds = settings.webhook_timeout
    try:
        return status.result(seconds)
    except TimeoutError as error:
        raise TimeoutError(f"the receiver did not answer within {seconds:g} s") from error


def _status(
    url: SplitResult, body: bytes, headers: dict[str, str], settings: WebhookSettings
) -> int:
    assert url.hostname is not None
    port = url.port or _PORTS[url.scheme]
    target = (url.path or "/") + (f"?{url.query}" if url.query else "")
    with _connected(_addresses(url.hostname, port, settings), port, settings) as connection:
        connection.settimeout(settings.webhook_timeout)
        exchange = http.client.HTTPConnection(url.hostname, port)
        exchange.sock = connection
        if url.scheme == "https":
            # The certificate must be that of the name, not of the address.
            context = ssl.create_default_context()
            exchange.sock = context.wrap_socket(connection, server_hostname=url.hostname)
        try:
            exchange.request("POST", target, body, {"Host": url.netloc, **headers})
            return exchange.getresponse().status
        finally:
            exchange.close()


def _addresses(host: str, port: int, settings: WebhookSettings) -> list[str]:
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    addresses = dict.fromkeys(str(entry[4][0]) for entry in found)
    public = [entry for entry in addresses if permitted(entry, settings.webhook_networks)]
    if not public:
        raise ReceiverNotPermitted(
            f"{host} is at no public address; ISOMATCH_WEBHOOK_NETWORKS can allow others"
        )
    return public


def _connected(addresses: list[str], port: int, settings: WebhookSettings) -> socket.socket:
    # A name may have any number of addresses; the worker is not theirs for longer than for one.
    *others, last = addresses[:_MOST_ADDRESSES]
    seconds = settings.webhook_timeout / (len(others) + 1)
    for address in others:
        with contextlib.suppress(OSError):
            return socket.create_connection((address, port), seconds)
    return socket.create_connection((last, port), seconds)


def _is_due(record: JobRecord) -> bool:
    delivered = record.delivery is not None and record.delivery.state is not DeliveryState.PENDING
    return record.state.ended and not delivered


def _body(record: JobRecord, summary: Summary | None) -> bytes:
    event = WebhookEvent.of(
        id=record.id,
        kind=record.kind,
        state=record.state,
        created=record.created,
        started=record.started,
        ended=record.ended,
        error=record.error,
        summary=summary if isinstance(summary, MatchSummary) else None,
    )
    return event.model_dump_json().encode()


def _headers(record: JobRecord, attempt: int) -> dict[str, str]:
    headers = {
        "Content-Type": "application/json",
        "User-Agent": "isomatch",
        "Isomatch-Delivery": record.id,
        "Isomatch-Attempt": str(attempt),
        "Connection": "close",
    }
    return headers | ({"X-Request-ID": record.request_id} if record.request_id else {})


def _delivery(outcome: Outcome, attempt: int, settings: WebhookSettings) -> Delivery:
    now = datetime.now(UTC)
    state, following = DeliveryState.DELIVERED, None
    if outcome.error is not None:
        state = DeliveryState.FAILED
        if not outcome.final and attempt < settings.webhook_attempts:
            state, following = DeliveryState.PENDING, now + retry_delay(attempt, settings)
    return Delivery(
        state=state,
        attempts=attempt,
        last_attempt=now,
        status=outcome.status,
        error=outcome.error,
        next_attempt=following,
    )
