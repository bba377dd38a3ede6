"""Context of the request that submits a job, and the record that makes requests idempotent."""

import hashlib
from dataclasses import dataclass
from typing import Self

from broker.contracts.webhooks import Webhook


@dataclass(frozen=True)
class IdempotencyRecord:
    """Identity of a request with an ``Idempotency-Key``.

    Parameters
    ----------
    name
        Digest of the caller and the key.
    content
        Digest of the request; the same key with different content is an error.
    seconds
        Time to live.
    """

    name: str
    content: str
    seconds: int

    @classmethod
    def of(cls, caller: str | None, key: str, content: tuple[bytes, ...], seconds: int) -> Self:
        """Return the record of a request.

        Parameters
        ----------
        caller
            Name of the API key; two callers may use the same idempotency key.
        key
            The idempotency key.
        content
            Method, path, body: all that two equal requests have in common.
        seconds
            Time to live.
        """
        return cls(_digest((caller or "").encode(), key.encode()), _digest(*content), seconds)


@dataclass(frozen=True)
class RequestOrigin:
    """The request that submits a job.

    Parameters
    ----------
    request_id
        Id of the request.
    caller
        Name of its API key; None where none is required.
    idempotency
        Its idempotency record, if it has a key.
    webhook
        Receiver to notify when the job has ended.
    traceparent
        Span that the job belongs to (W3C Trace Context); None for the present one.
    """

    request_id: str | None = None
    caller: str | None = None
    idempotency: IdempotencyRecord | None = None
    webhook: Webhook | None = None
    traceparent: str | None = None


def _digest(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        # The lengths keep the borders between the parts.
        digest.update(len(part).to_bytes(8, "big") + part)
    return digest.hexdigest()
