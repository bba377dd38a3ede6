"""Records of new jobs."""

import re
from datetime import UTC, datetime
from typing import Final
from uuid import uuid4

from broker.contracts import BatchPayload, JobRecord, Payload, RequestOrigin, TimeSlicePayload
from broker.tracing import traceparent

NO_REQUEST: Final = RequestOrigin()
"""Context of a job that no request submitted."""


_MATCH: Final = re.compile(r"(.+)-([1-9][0-9]{0,8})")


def new_job(payload: Payload, context: RequestOrigin = NO_REQUEST) -> JobRecord:
    """Return the record of a new job.

    Parameters
    ----------
    payload
        Kind and parameters of the job.
    context
        The request that submits it.
    """
    return JobRecord(
        id=uuid4().hex,
        payload=payload,
        created=datetime.now(UTC),
        request_id=context.request_id,
        caller=context.caller,
        # Jobs that serve a listed one do not notify its receiver.
        webhook=context.webhook if payload.kind.has_result else None,
        traceparent=context.traceparent or traceparent(),
    )


def new_time_slice(record: JobRecord, number: int) -> JobRecord:
    """Return the record of a time slice of a job."""
    return JobRecord(
        id=time_slice_id(record, number),
        payload=TimeSlicePayload(job=record.id),
        created=datetime.now(UTC),
        request_id=record.request_id,
        caller=record.caller,
        traceparent=record.traceparent,
    )


def new_batch_match(record: JobRecord, place: int) -> JobRecord:
    """Return the record of the match with the target at a place of a batch."""
    assert isinstance(record.payload, BatchPayload)
    return JobRecord(
        id=batch_match_id(record.id, place),
        payload=record.payload.match(place),
        created=datetime.now(UTC),
        request_id=record.request_id,
        caller=record.caller,
        batch=record.id,
        traceparent=record.traceparent,
    )


def batch_match_id(batch: str, place: int) -> str:
    """Return the id of the match with the target at a place of a batch, counted from 0."""
    return f"{batch}-{place + 1}"


def parsed_match_id(job: str) -> tuple[str, int]:
    """Return the batch and the place there that an id names; no batch if it is that of no match."""
    named = _MATCH.fullmatch(job)
    return ("", 0) if named is None else (named[1], int(named[2]) - 1)


def time_slice_id(record: JobRecord, number: int) -> str:
    """Return the id of a time slice, counted from 1."""
    return f"{record.id}-{number}"
