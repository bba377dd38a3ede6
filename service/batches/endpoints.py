"""``/v1/batches``."""

import gzip
from contextlib import suppress

from fastapi import APIRouter

from broker.blobs import BlobLost
from broker.contracts import (
    BatchMatch,
    BatchPayload,
    BatchResult,
    JobRecord,
    JobState,
    is_prototype,
)
from service.batches.schemas import BatchProgress, BatchRequest
from service.dependencies import Service, ServiceOf
from service.http import (
    InvalidRequest,
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    UnknownPrototype,
    responses,
)
from service.jobs import Job, JobId, JobOrderOf, answers, stored_job
from service.matches import checked_parameters

router = APIRouter(prefix="/v1/batches", tags=["batches"])


@router.post(
    "",
    status_code=202,
    responses=answers(UnknownPrototype),
    operation_id="create_batch",
)
def create_batch(asked: BatchRequest, order: JobOrderOf) -> Job:
    """Match one source with many targets: each match is a job of its own, with its own result.

    Parameters are those of a match, the same for all; `partial` links to the matches, which follow
    one another as workers are free. A match that fails does not end the batch. To cancel the batch
    cancels its matches.
    """
    return order.job(asked, _payload)


@router.get(
    "/{job_id}",
    responses=responses(JobNotFound, JobExpired, JobWithoutResult, InvalidRequest),
    operation_id="get_batch",
)
def get_batch(job_id: JobId, service: ServiceOf) -> BatchProgress:
    """Return the matches of a batch: the state of each, and the answer in brief where there is one.

    Also of a batch that was cancelled: matches that had ended keep their results.
    """
    record = stored_job(service, job_id)
    payload = record.payload
    if not isinstance(payload, BatchPayload):
        raise JobWithoutResult(f"A {record.kind.value} has no matches; ask for its result.")
    matches = _matches(service, record)
    return BatchProgress(
        job=record.id,
        state=record.state,
        source=payload.source,
        source_name=payload.source_name,
        ended=sum(one.state.ended for one in matches),
        matches=matches,
    )


def _matches(service: Service, record: JobRecord) -> tuple[BatchMatch, ...]:
    if record.state is JobState.SUCCEEDED:
        packed = None
        with suppress(BlobLost):
            packed = service.store.results.document(record.id)
        if packed is not None:  # records of its matches may have expired before
            return BatchResult.model_validate_json(gzip.decompress(packed)).matches
    return service.queue.batches.matches(record)


def _payload(asked: BatchRequest, service: Service) -> BatchPayload:
    fields = {f"body.targets.{place}": target for place, target in enumerate(asked.targets)}
    parameters = checked_parameters(asked, fields, service)
    kept = service.store.prototypes if is_prototype(asked.source) else service.store.shapes
    source, targets = kept.get(asked.source), service.store.shapes.records(asked.targets)
    given = asked.target_names or (None,) * len(targets)
    return BatchPayload(
        source=asked.source,
        source_name=asked.source_name or (None if source is None else source.name),
        targets=asked.targets,
        target_names=tuple(
            name or (None if target is None else target.name)
            for name, target in zip(given, targets, strict=True)
        ),
        parameters=parameters,
    )
