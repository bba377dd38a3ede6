"""Transfers along a match: of attribute files, of the shape's own attributes, and of landmarks."""

import time
from collections.abc import Sequence
from typing import Final, Literal

from broker.contracts import (
    LANDMARKS,
    UV,
    AttributeElement,
    AttributesRecord,
    AttributeSummary,
    AttributesValidationPayload,
    Confidence,
    TransferPayload,
    TransferResult,
)
from broker.store import Store
from solver.errors import OptionError
from solver.transfer import FACES, VERTICES, Attribute
from solver.transfer.files import read_attributes, write_npz
from worker.jobs.carrying import TransferRequest, carried_by, carried_from
from worker.jobs.context import JobContext, JobResult
from worker.jobs.failures import ResultGone
from worker.jobs.landmarks import image_of, landmark_arrays, point_arrays
from worker.jobs.match_results import result_from_blob
from worker.jobs.meshes import stored_mesh
from worker.jobs.uploads import stored_once

_ON: Final[dict[str, AttributeElement]] = {VERTICES: "vertices", FACES: "faces"}


def validate_attributes(payload: AttributesValidationPayload, context: JobContext) -> None:
    """Store the attribute file of a job's upload.

    Raises
    ------
    TransferError
        The upload is not a usable attribute file.
    UploadGone
        The upload has expired.
    """
    store, job = context.store, context.record
    with stored_once(store.attributes, payload.attributes):
        data = store.uploads.candidate(payload.attributes, payload.file_type, job.id)
        found = read_attributes(data, payload.file_type)
        record = AttributesRecord(
            id=payload.attributes,
            name=payload.name,
            file_type=payload.file_type,
            bytes=len(data),
            rows=len(found[0].values),
            attributes=tuple(map(summary_of, found)),
            created=job.created,
        )
        store.attributes.accept(record, data, job.id)


def carry(payload: TransferPayload, context: JobContext) -> JobResult:
    """Carry attributes or landmarks along a match.

    Raises
    ------
    ResultGone, ShapeGone, AttributesGone
        The match's result, a shape or the attribute file expired or was deleted.
    OptionError, TransferError
        The attributes cannot be carried.
    Cancelled
        Through the reporter.
    """
    start = time.perf_counter()
    store, control = context.store, context.reporter.control()
    control.report("reading the match", 0.0)
    packed = store.results.document(payload.match)
    if packed is None:
        raise ResultGone("the result of the match has expired; match again")
    match = result_from_blob(packed)
    dense, forwards = match.dense, payload.direction == "source_to_target"
    # By the direction: source and target may be one shape, of two names.
    names = (match.source_name, match.target_name)[:: 1 if forwards else -1]
    if dense is None or dense.inverse is None:
        raise OptionError("match", "it has no map in both directions; match again with `dense`")
    along = dense, dense.inverse, match.confidence, match.overlap
    found = carried_by(TransferRequest(payload, *along, context, control))
    carried, landmarks = found.attributes, found.landmarks
    # The map of an alternative is not that of the answer, which confidence is of.
    confidence = match.confidence if dense.hypothesis == 0 else None
    result = TransferResult(
        job=context.record.id,
        match=payload.match,
        source=payload.source,
        target=payload.target,
        source_name=names[0],
        target_name=names[1],
        what=payload.what,
        direction=payload.direction,
        on=_on(carried, payload),
        rows=len(carried[0].values) if carried else 0,
        attributes=tuple(map(summary_of, carried)),
        points=None if landmarks is None else tuple(map(image_of, landmarks)),
        landmarks=landmarks,
        confidence=confidence,
        warnings=(*_in_doubt(confidence), *found.warnings),
        timings={"total": time.perf_counter() - start},
    )
    arrays = write_npz(carried) if landmarks is None else landmark_arrays(landmarks)
    return JobResult(result.model_dump_json().encode(), arrays)


def source_arrays(payload: TransferPayload, result: TransferResult, store: Store) -> bytes:
    """Return what a transfer carried, as it is on its source, in the form of its own arrays.

    Parameters
    ----------
    payload, result
        Of the job.
    store
        Store of the shapes and files.

    Raises
    ------
    ShapeGone, AttributesGone
        The shape or the attribute file expired or was deleted.
    """
    if payload.what == LANDMARKS:
        # Results of earlier versions have no more than images, of points that were given.
        placed = [one.on_source for one in result.landmarks or ()]
        return write_npz(point_arrays(placed if payload.points is None else payload.points))
    return write_npz(carried_from(payload, stored_mesh(payload.source, store.shapes), store))


def summary_of(attribute: Attribute) -> AttributeSummary:
    """Return the description of an attribute."""
    kinds: dict[str, Literal["number", "integer", "text"]] = {"U": "text", "i": "integer"}
    return AttributeSummary(
        name=attribute.name,
        type=kinds.get(attribute.values.dtype.kind, "number"),
        columns=attribute.columns or tuple(map(str, range(attribute.width))),
        on=_ON.get(attribute.on or ""),
        rows=len(attribute.values),
    )


def _on(
    carried: Sequence[Attribute], payload: TransferPayload
) -> Literal["vertices", "faces", "corners"]:
    if payload.what == UV:
        return "corners"
    return "faces" if carried and carried[0].on == FACES else "vertices"


def _in_doubt(confidence: Confidence | None) -> tuple[str, ...]:
    """Warn of values that may be carried to wrong places."""
    if confidence is None or not confidence.in_doubt:
        return ()
    return ("the match is in doubt: what it carries may lie in wrong places",)
