"""Pictures of results: of a match, of a match with a prototype, of a dissimilarity matrix."""

import gzip
from collections.abc import Sequence

from broker.contracts import DissimilarityResult, JobKind, MatchResult, PicturePayload
from broker.store import Store
from worker.jobs.archives import stored_prototype
from worker.jobs.context import JobContext
from worker.jobs.failures import ResultGone
from worker.jobs.match_results import result_from_blob
from worker.jobs.meshes import stored_mesh
from worker.pictures import (
    Hypothesis,
    draw_match,
    draw_matrix,
    draw_prototype_match,
    hypothesis_of,
)


def draw(payload: PicturePayload, context: JobContext) -> None:
    """Draw the result of a job, or one of its alternatives, and store the picture.

    Raises
    ------
    ResultGone, ShapeGone, PrototypeGone
        The result, or what it is of, has expired or was deleted.
    NoAlternative
        The match has no such alternative.
    """
    store = context.store
    packed, drawn = store.results.document(payload.job), store.jobs.get(payload.job)
    if packed is None or drawn is None:
        raise ResultGone("the result has expired")
    if drawn.kind is JobKind.DISSIMILARITIES:
        matrix = DissimilarityResult.model_validate_json(gzip.decompress(packed))
        picture = draw_matrix(matrix, _names(matrix.shapes, store))
    else:
        result = result_from_blob(packed)
        answer = hypothesis_of(result, payload.alternative)
        of_prototype = result.source_kind == "prototype"
        draw_answer = _draw_prototype_match if of_prototype else _draw_match
        picture = draw_answer(result, answer, store)
    store.results.set_picture(payload.job, payload.alternative, picture)


def _draw_match(result: MatchResult, answer: Hypothesis, store: Store) -> bytes:
    source, target = _names((result.source, result.target), store)
    meshes = stored_mesh(result.source, store.shapes), stored_mesh(result.target, store.shapes)
    return draw_match(*meshes, answer, (source, target))


def _draw_prototype_match(result: MatchResult, answer: Hypothesis, store: Store) -> bytes:
    prototype = stored_prototype(store, result.source)
    record = store.prototypes.get(result.source)
    name = "" if record is None else f"{record.name}, version {record.version}"
    (target,) = _names((result.target,), store)
    mesh = stored_mesh(result.target, store.shapes)
    return draw_prototype_match(prototype.positions, mesh, answer, (name, target))


def _names(shapes: Sequence[str], store: Store) -> list[str]:
    records = store.shapes.records(shapes)
    return ["" if record is None else record.name for record in records]
