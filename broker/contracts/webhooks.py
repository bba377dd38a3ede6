"""Webhooks: the receiver, the event it is sent, and the state of the delivery."""

import re
from datetime import datetime
from enum import StrEnum
from typing import Annotated, Any, Final, Literal
from urllib.parse import urlsplit

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from broker.contracts.job_kinds import JobKind, JobState
from broker.contracts.problems import Problem
from broker.contracts.strict import BoundedModel
from broker.contracts.summaries import MatchSummary

LONGEST_URL: Final = 2000
_PLAIN: Final = re.compile(r"[!-~]+")


def _receiver(url: str) -> str:
    if not _PLAIN.fullmatch(url):
        raise ValueError("Input should be ASCII without blanks; encode what is not")
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise ValueError("Input should be an http:// or https:// address")
    if parts.username is not None or parts.password is not None:
        raise ValueError("Input should have no user name or password; give a `secret` instead")
    if parts.port == 0:
        raise ValueError("Port out of range 1-65535")
    return url


class Webhook(BoundedModel):
    """Receiver of the notification that the job has ended, in whatever state."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        strict=True,
        json_schema_extra={
            "examples": [
                {
                    "url": "https://example.org/isomatch",
                    "secret": "at-least-sixteen-characters",
                }
            ]
        },
    )

    url: Annotated[str, AfterValidator(_receiver)] = Field(
        min_length=1,
        max_length=LONGEST_URL,
        description="Address that is sent a POST. It must be a public one, unless the service is"
        " set up to allow others.",
    )
    secret: str | None = Field(
        default=None,
        min_length=16,
        max_length=256,
        repr=False,
        description="Key of the signature of the POST, by which the receiver verifies the sender.",
    )


class DeliveryState(StrEnum):
    """State of a delivery: pending, and then delivered or failed."""

    PENDING = "pending"
    DELIVERED = "delivered"
    FAILED = "failed"


class Delivery(BaseModel):
    """State of the delivery of a webhook, and its last attempt."""

    model_config = ConfigDict(frozen=True)

    state: DeliveryState = Field(
        default=DeliveryState.PENDING,
        description="pending until the receiver took it (delivered) or was tried for the last"
        " time (failed).",
    )
    attempts: int = Field(default=0, description="How often it was tried.")
    last_attempt: datetime | None = Field(default=None, description="When it was tried last.")
    status: int | None = Field(
        default=None, description="HTTP status the receiver answered with last, if it did."
    )
    error: str | None = Field(default=None, description="What went wrong last.")
    next_attempt: datetime | None = Field(default=None, description="When it is tried again.")


class EndedJob(BaseModel):
    """A job that has ended, as a webhook event describes it."""

    model_config = ConfigDict(frozen=True)

    id: str = Field(description="Id of the job.")
    kind: JobKind = Field(description="Kind of the job.")
    state: JobState = Field(description="succeeded, failed or cancelled.")
    created: datetime = Field(description="When it was requested.")
    started: datetime | None = Field(description="When it was begun; null if it never was.")
    ended: datetime | None = Field(description="When it ended.")
    error: Problem | None = Field(description="Why it failed; null if it did not.")
    summary: MatchSummary | None = Field(
        description="Of a match that has succeeded, the answer in brief; else null."
    )
    path: str = Field(description="Where the job, and from there its result, is found.")


class WebhookEvent(BaseModel):
    """Event that is sent to the receiver of a webhook."""

    model_config = ConfigDict(
        frozen=True,
        json_schema_extra={
            "examples": [
                {
                    "type": "job.ended",
                    "job": {
                        "id": "5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f",
                        "kind": "match",
                        "state": "succeeded",
                        "created": "2026-03-01T12:00:00Z",
                        "started": "2026-03-01T12:00:01Z",
                        "ended": "2026-03-01T12:00:09Z",
                        "error": None,
                        "summary": None,
                        "path": "/v1/jobs/5f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f",
                    },
                }
            ]
        },
    )

    type: Literal["job.ended"] = Field(description="What happened.")
    job: EndedJob = Field(description="The job.")

    @classmethod
    def of(cls, **job: Any) -> "WebhookEvent":
        """Return the event that a job has ended."""
        return cls(type="job.ended", job=EndedJob(path=f"/v1/jobs/{job['id']}", **job))
