"""Records as they are kept, JSON, while older and newer versions read them.

What is asked is kept without what is the default anyway, so that versions which do not know a
parameter yet read the records of all who do not use it. One that they cannot read is left to those
who can.
"""

import json
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from broker.contracts import JobRecord

RecordT = TypeVar("RecordT", bound=BaseModel)

_KEPT = {"id", "payload", "created", "request_id", "caller", "webhook"}
"""What of a job's record never changes."""


class NewerRecord(Exception):  # noqa: N818 - said of the record
    """A record is of a form that this version does not know: a newer one wrote it.

    Parameters
    ----------
    kind
        What it is the record of.
    """

    def __init__(self, kind: type[BaseModel]) -> None:
        super().__init__(f"a {kind.__name__} was written by a newer version")


def read_record(kind: type[RecordT], data: bytes | str) -> RecordT:
    """Read a record.

    Raises
    ------
    NewerRecord
        It has what this version does not know.
    ValidationError
        It is damaged.
    """
    try:
        return kind.model_validate_json(data)
    except ValidationError as error:
        if any(one["type"] == "json_invalid" for one in error.errors(include_input=False)):
            raise  # no version wrote this
        raise NewerRecord(kind) from error


def job_document(record: JobRecord) -> str:
    """Return what is kept of a new job."""
    document = record.model_dump(mode="json", include=_KEPT)
    parameters = getattr(record.payload, "parameters", None)
    if parameters is not None:
        asked = parameters.model_dump(mode="json", exclude_defaults=True)
        document["payload"]["parameters"] = asked
    return json.dumps(document)
