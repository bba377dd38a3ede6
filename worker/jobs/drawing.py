"""Pictures of results, and results in other formats: of a match, a matrix or a transfer."""

import gzip
from collections.abc import Callable, Mapping
from typing import Final

from broker.contracts import (
    DissimilarityResult,
    JobKind,
    JobRecord,
    MatchPayload,
    MatchResult,
    PicturePayload,
    RegistrationResult,
    TransferPayload,
    TransferResult,
)
from broker.store import Store
from worker.jobs.archives import stored_prototype
from worker.jobs.context import JobContext
from worker.jobs.exports import (
    export_consistent_map,
    export_dense_map,
    export_match,
    export_matrix,
    export_transfer,
)
from worker.jobs.failures import ResultGone
from worker.jobs.match_results import result_from_blob
from worker.jobs.meshes import stored_mesh
from worker.jobs.progress import SHARE_FOR_PARTS
from worker.jobs.registered_files import (
    draw_registration,
    export_match_registered,
    export_registered,
)
from worker.jobs.shape_names import shape_names
from worker.jobs.transfers import source_arrays
from worker.pictures import draw_match, draw_matrix, draw_prototype_match, hypothesis_of


def draw(payload: PicturePayload, context: JobContext) -> None:
    """Draw the result of a job, or one of its alternatives, or write it to a file, and store that.

    Raises
    ------
    ResultGone, ShapeGone, PrototypeGone
        The result, or what it is of, has expired or was deleted.
    NoAlternative
        The match has no such alternative.
    OptionError, TransferError
        The result cannot be written in this format.
    QuotaExceeded
        The tenant has as many bytes as it may have.
    Cancelled
        Through the reporter.
    """
    store = context.store
    packed, drawn = store.results.document(payload.job), store.jobs.get(payload.job)
    if packed is None or drawn is None:
        raise ResultGone("the result has expired")
    store.results.set_picture(payload, _PRESENTED[drawn.kind](packed, drawn, payload, context))


def _matrix(packed: bytes, _: JobRecord, payload: PicturePayload, context: JobContext) -> bytes:
    matrix = DissimilarityResult.model_validate_json(gzip.decompress(packed))
    present = draw_matrix if payload.format == "png" else export_matrix
    names = matrix.names or [name or "" for name in shape_names(matrix.shapes, None, context.store)]
    return present(matrix, names)


def _transfer(
    packed: bytes, drawn: JobRecord, payload: PicturePayload, context: JobContext
) -> bytes:
    result = TransferResult.model_validate_json(gzip.decompress(packed))
    if payload.format == "npz":
        assert isinstance(drawn.payload, TransferPayload)
        return source_arrays(drawn.payload, result, context.store)
    return export_transfer(result, payload.job, payload.format, context.store)


def _registration(
    packed: bytes, _: JobRecord, payload: PicturePayload, context: JobContext
) -> bytes:
    result = RegistrationResult.model_validate_json(gzip.decompress(packed))
    if payload.format == "png":
        return draw_registration(result, payload.job, context.store)
    return export_registered(result, payload.job, payload.specimen, payload.format, context.store)


def _match(packed: bytes, drawn: JobRecord, payload: PicturePayload, context: JobContext) -> bytes:
    result = result_from_blob(packed)
    if payload.specimen is not None:
        assert isinstance(drawn.payload, MatchPayload)
        seconds = SHARE_FOR_PARTS * context.queue.settings.timeout(context.record.kind)
        control = context.reporter.control().within(seconds)
        return export_match_registered(
            result, drawn.payload, payload.format, context.store, control
        )
    if payload.pair is not None:
        return export_dense_map(result, payload.pair)
    if payload.format != "png":
        return export_match(result, payload.format, context.store)
    return _drawn_match(result, payload, context.store)


def _consistent_map(
    _: bytes, drawn: JobRecord, payload: PicturePayload, context: JobContext
) -> bytes:
    assert payload.pair is not None
    return export_consistent_map(drawn.id, payload.pair, context.store)


_Present = Callable[[bytes, JobRecord, PicturePayload, JobContext], bytes]

_PRESENTED: Final[Mapping[JobKind, _Present]] = {
    JobKind.DISSIMILARITIES: _matrix,
    JobKind.TRANSFER: _transfer,
    JobKind.REGISTRATION: _registration,
    JobKind.MATCH: _match,
    JobKind.CONSISTENT_MAPS: _consistent_map,
}
"""Pictures and files of the results of each kind of jobs that has some."""


def _drawn_match(result: MatchResult, payload: PicturePayload, store: Store) -> bytes:
    answer = hypothesis_of(result, payload.alternative)
    (target_name,) = shape_names([result.target], [result.target_name], store)
    target = stored_mesh(result.target, store.shapes)
    if result.source_kind == "prototype":
        prototype, record = (
            stored_prototype(store, result.source),
            store.prototypes.get(result.source),
        )
        name = "" if record is None else f"{record.name}, version {record.version}"
        names = name, target_name or ""
        return draw_prototype_match(prototype, target, answer, names, payload.view)
    (source_name,) = shape_names([result.source], [result.source_name], store)
    names = source_name or "", target_name or ""
    source = stored_mesh(result.source, store.shapes)
    return draw_match(source, target, answer, names, payload.view)
