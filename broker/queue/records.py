"""Records of jobs that begin."""

from datetime import UTC, datetime
from typing import Final
from uuid import uuid4

from broker.contracts import JobRecord, Order, Payload, TurnPayload
from broker.store import LISTED_KINDS

UNASKED: Final = Order()
"""How a job comes about that no request asked for."""


def new_job(payload: Payload, order: Order = UNASKED) -> JobRecord:
    """Return the record of a new job.

    Parameters
    ----------
    payload
        What it is to do.
    order
        How it was asked for.
    """
    return JobRecord(
        id=uuid4().hex,
        payload=payload,
        created=datetime.now(UTC),
        request_id=order.request_id,
        caller=order.caller,
        # Jobs that only serve the one that was asked for have an end of their own.
        webhook=order.webhook if payload.kind in LISTED_KINDS else None,
    )


def turn_of(record: JobRecord, number: int) -> JobRecord:
    """Return the record of a turn of a job that is done in turns."""
    return JobRecord(
        id=turn_id(record, number),
        payload=TurnPayload(job=record.id),
        created=datetime.now(UTC),
        request_id=record.request_id,
        caller=record.caller,
    )


def turn_id(record: JobRecord, number: int) -> str:
    """Return the id of a turn, counted from 1."""
    return f"{record.id}-{number}"
