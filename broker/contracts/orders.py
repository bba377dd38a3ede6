"""How a job is asked for: in which request, by whom, and how it is known when asked for again."""

import hashlib
from dataclasses import dataclass
from typing import Self

from broker.contracts.webhooks import Webhook


@dataclass(frozen=True)
class Once:
    """What makes a repeated request the same request (its ``Idempotency-Key``).

    Parameters
    ----------
    name
        Digest of the caller and the key.
    content
        Digest of everything that was asked; the same key with anything else is a mistake.
    seconds
        How long the key is remembered.
    """

    name: str
    content: str
    seconds: int

    @classmethod
    def of(cls, caller: str | None, key: str, content: tuple[bytes, ...], seconds: int) -> Self:
        """Return what identifies a request.

        Parameters
        ----------
        caller
            Whose key it is; two callers may use the same.
        key
            The key as the caller sent it.
        content
            Method, path, body: all that two equal requests have in common.
        seconds
            How long the key is remembered.
        """
        return cls(_digest((caller or "").encode(), key.encode()), _digest(*content), seconds)


@dataclass(frozen=True)
class Order:
    """How a job is asked for.

    Parameters
    ----------
    request_id
        Name of the request.
    caller
        Name of the API key it came with; None where none is asked for.
    once
        How the request is known again, if its sender wants it to be.
    webhook
        Whom to tell when the job has ended.
    """

    request_id: str | None = None
    caller: str | None = None
    once: Once | None = None
    webhook: Webhook | None = None


def _digest(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        # With the lengths, what belongs to one part cannot be taken for the next one's.
        digest.update(len(part).to_bytes(8, "big") + part)
    return digest.hexdigest()
