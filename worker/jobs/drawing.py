"""Pictures of results, and results in other formats: of a match, a matrix or a transfer."""

import gzip

from broker.contracts import (
    DissimilarityResult,
    JobKind,
    MatchPayload,
    MatchResult,
    PicturePayload,
    RegistrationResult,
    TransferResult,
)
from broker.store import Store
from worker.jobs.archives import stored_prototype
from worker.jobs.context import JobContext
from worker.jobs.exports import export_match, export_matrix, export_transfer
from worker.jobs.failures import ResultGone
from worker.jobs.match_results import result_from_blob
from worker.jobs.meshes import stored_mesh
from worker.jobs.registered_files import (
    draw_registration,
    export_match_registered,
    export_registered,
)
from worker.jobs.shape_names import shape_names
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
    """
    store = context.store
    packed, drawn = store.results.document(payload.job), store.jobs.get(payload.job)
    if packed is None or drawn is None:
        raise ResultGone("the result has expired")
    if drawn.kind is JobKind.DISSIMILARITIES:
        matrix = DissimilarityResult.model_validate_json(gzip.decompress(packed))
        present = draw_matrix if payload.format == "png" else export_matrix
        names = matrix.names or [name or "" for name in shape_names(matrix.shapes, None, store)]
        picture = present(matrix, names)
    elif drawn.kind is JobKind.TRANSFER:
        carried = TransferResult.model_validate_json(gzip.decompress(packed))
        picture = export_transfer(carried, payload.job, payload.format, store)
    elif drawn.kind is JobKind.REGISTRATION:
        registered = RegistrationResult.model_validate_json(gzip.decompress(packed))
        picture = _presented_registration(registered, payload, store)
    elif payload.specimen is not None:
        assert isinstance(drawn.payload, MatchPayload)
        found = result_from_blob(packed)
        picture = export_match_registered(found, drawn.payload, payload.format, store)
    elif payload.format != "png":
        picture = export_match(result_from_blob(packed), payload.format, store)
    else:
        picture = _drawn_match(result_from_blob(packed), payload, store)
    store.results.set_picture(payload, picture)


def _presented_registration(
    result: RegistrationResult, payload: PicturePayload, store: Store
) -> bytes:
    if payload.format == "png":
        return draw_registration(result, payload.job, store)
    return export_registered(result, payload.job, payload.specimen, payload.format, store)


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
