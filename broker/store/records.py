"""Records as JSON that older and newer versions read.

Parameters are stored without those that have their default, so that a version that does not know a
parameter reads the records of all who do not use it. A record that it cannot read is left to newer
processes.
"""

import json
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from broker.contracts import JobRecord

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


def job_document(record: JobRecord) -> str:
    """Return the stored form of a new job."""
    document = record.model_dump(mode="json", include=_CONSTANT_FIELDS)
    parameters = getattr(record.payload, "parameters", None)
    if parameters is not None:
        chosen = parameters.model_dump(mode="json", exclude_defaults=True)
        document["payload"]["parameters"] = chosen
    return json.dumps(document)
