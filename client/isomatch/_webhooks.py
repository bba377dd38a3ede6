"""Webhooks: notifications of ended jobs, and the verification of their signatures."""

import hashlib
import hmac
import time
from datetime import datetime
from typing import NotRequired

from pydantic import ValidationError

# Pydantic reads a TypedDict of the standard library only from Python 3.12 on.
from typing_extensions import TypedDict

from isomatch._errors import InvalidSignature
from isomatch._models import Answer, AnsweredState, MatchSummary
from isomatch._problem import Problem


class Webhook(TypedDict):
    """Receiver of a notification when a job has ended.

    Attributes
    ----------
    url
        Address for a POST request; a public one, unless the service allows others.
    secret
        Secret of the signature, 16 to 256 characters; see :func:`verify_webhook`.
    """

    url: str
    secret: NotRequired[str]


class EndedJob(Answer):
    """An ended job in a webhook.

    Attributes
    ----------
    id, kind, state, created, started, ended, error, summary
        As of :class:`isomatch.Job`.
    path
        Path of the job on the service.
    """

    id: str
    kind: str
    state: AnsweredState
    created: datetime
    started: datetime | None
    ended: datetime | None
    error: Problem | None
    summary: MatchSummary | None = None
    path: str


class WebhookEvent(Answer):
    """Body of a webhook.

    Attributes
    ----------
    type
        ``"job.ended"``.
    job
        The job.
    """

    type: str
    job: EndedJob


def verify_webhook(
    body: bytes, signature: str | None, secret: str, tolerance: float = 300.0
) -> WebhookEvent:
    """Return the event of a webhook if its signature is valid and recent.

    Parameters
    ----------
    body
        Body of the request, byte for byte.
    signature
        Header ``Isomatch-Signature`` of the request; None without one.
    secret
        Secret that was given when the job was started.
    tolerance
        Greatest difference, in seconds, between now and the time of the signature.

    Raises
    ------
    InvalidSignature
        The signature is missing, of another secret or too old, or the body was changed.
    """
    parts = dict(part.strip().partition("=")[::2] for part in (signature or "").split(","))
    stated, digest = parts.get("t", ""), parts.get("v1", "")
    signed = stated.encode() + b"." + body
    expected = hmac.new(secret.encode(), signed, hashlib.sha256).hexdigest()
    if not hmac.compare_digest(expected.encode(), digest.encode()):
        raise InvalidSignature("the webhook is not signed with this secret")
    if not stated.isdecimal() or abs(time.time() - int(stated)) > tolerance:
        raise InvalidSignature(f"the webhook was not signed within {tolerance:g} s of now")
    try:
        return WebhookEvent.model_validate_json(body)
    except ValidationError as error:
        raise InvalidSignature("the webhook is signed, but is not about a job") from error
