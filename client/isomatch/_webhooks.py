"""Webhooks: whom the service is to tell that a job has ended, and how a receiver trusts it."""

import hashlib
import hmac
import time
from datetime import datetime
from typing import Literal, NotRequired, TypeAlias

from pydantic import ValidationError

# Pydantic reads a TypedDict of the standard library only from Python 3.12 on.
from typing_extensions import TypedDict

from isomatch._errors import InvalidSignature
from isomatch._models import Answer, JobState
from isomatch._problem import Problem

DeliveryState: TypeAlias = Literal["pending", "delivered", "failed"]


class Webhook(TypedDict):
    """Whom to tell when a job has ended, however it ends.

    Attributes
    ----------
    url
        Address that is sent a POST; a public one, unless the service allows others.
    secret
        What the POST is signed with, 16 to 256 characters; :func:`verify_webhook` needs it too.
    """

    url: str
    secret: NotRequired[str]


class EndedJob(Answer):
    """A job that has ended, as receivers of webhooks are told.

    Attributes
    ----------
    id, kind, state, created, started, ended, error
        As of :class:`isomatch.Job`.
    path
        Where the service has it.
    """

    id: str
    kind: str
    state: JobState
    created: datetime
    started: datetime | None
    ended: datetime | None
    error: Problem | None
    path: str


class WebhookEvent(Answer):
    """What a receiver is told.

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
    """Return what a webhook tells, if it was sent by somebody who knows the secret, and just now.

    Parameters
    ----------
    body
        The body of the request, byte by byte as it came in.
    signature
        Its header ``Isomatch-Signature``; None if it has none.
    secret
        The secret that was given when the job was asked for.
    tolerance
        Seconds by which it may have been signed before now, or after, as clocks differ.

    Raises
    ------
    InvalidSignature
        It is not signed, or with another secret, or long ago, or was changed on the way.
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
        raise InvalidSignature("the webhook is signed and tells of no job") from error
