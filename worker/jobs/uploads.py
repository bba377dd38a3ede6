"""Uploads that jobs validate: each is stored by one run of its job."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from broker.store import CandidateGone, RecordStore
from worker.jobs.failures import UploadGone


@contextmanager
def stored_once(records: RecordStore[Any], record_id: str) -> Iterator[None]:
    """Store an upload, unless an earlier run of the job has: its candidate is gone then.

    Raises
    ------
    UploadGone
        The upload has expired.
    """
    try:
        yield
    except CandidateGone:
        if records.get(record_id) is None or records.lost(record_id):
            raise UploadGone from None
