"""Records as JSON that older and newer versions read.

Parameters are stored without those that have their default, so that a version that does not know a
parameter reads the records of all who do not use it. A record that it cannot read is left to newer
processes.
"""

import json
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

from pydantic import BaseModel, ValidationError
from redis import Redis

from broker.contracts import JobRecord
from broker.telemetry import logger

log = logger("isomatch.records")

RecordT = TypeVar("RecordT", bound=BaseModel)

_CONSTANT_FIELDS = {"id", "payload", "created", "request_id", "caller", "webhook", "batch"} | {
    "traceparent"
}
"""Fields of a job's record that never change."""


class NewerRecord(Exception):
    """A record has a form that this version does not know: a newer one wrote it.

    Parameters
    ----------
    kind
        Type of the record.
    """

    def __init__(self, kind: type[BaseModel]) -> None:
        super().__init__(f"a {kind.__name__} was written by a newer version")


def read_record(kind: type[RecordT], data: bytes | str) -> RecordT:
    """Read a record.

    Raises
    ------
    NewerRecord
        A newer version wrote it.
    ValidationError
        It is damaged.
    """
    try:
        return kind.model_validate_json(data)
    except ValidationError as error:
        if any(one["type"] == "json_invalid" for one in error.errors(include_input=False)):
            raise  # no version writes this
        raise NewerRecord(kind) from error


def readable(kind: type[RecordT], name: str, read: Callable[[], RecordT]) -> RecordT | None:
    """Return a record, or None if it cannot be read.

    Parameters
    ----------
    kind, name
        Type and id of the record, for the log.
    read
        Reads it.
    """
    try:
        return read()
    except NewerRecord:
        return None  # left to processes of the newer version
    except (ValueError, KeyError) as error:
        # The error's text may quote the record, which may hold secrets.
        log.error("a record is damaged", kind=kind.__name__, id=name, error=type(error).__name__)
        return None


def readable_records(
    client: Redis, kind: type[RecordT], names: Sequence[str], key: Callable[[str], str]
) -> list[RecordT | None]:
    """Return records by their ids, None for each that does not exist or cannot be read."""
    found = client.mget([key(name) for name in names])
    return [
        None if data is None else readable(kind, name, partial(read_record, kind, data))
        for name, data in zip(names, found, strict=True)
    ]


def job_document(record: JobRecord) -> str:
    """Return the stored form of a new job."""
    document = record.model_dump(mode="json", include=_CONSTANT_FIELDS)
    parameters = getattr(record.payload, "parameters", None)
    if parameters is not None:
        chosen = parameters.model_dump(mode="json", exclude_defaults=True)
        document["payload"]["parameters"] = chosen
    return json.dumps(document)
