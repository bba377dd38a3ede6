"""``/v1/jobs/{id}/result``: results as JSON and as arrays."""

from typing import Annotated, Final, TypeAlias

from fastapi import APIRouter, Response
from pydantic import Field

from broker.contracts import (
    BatchPayload,
    BatchResult,
    ConsistentMapsResult,
    DissimilarityResult,
    MatchResult,
    PrototypeResult,
    RegistrationResult,
    TransferResult,
)
from service.dependencies import ServiceOf
from service.http import (
    AcceptEncoding,
    ContentLost,
    InvalidRequest,
    JobExpired,
    JobNotFound,
    JobWithoutResult,
    ResultExpired,
    ResultNotReady,
    attachment,
    binary_file,
    file_response,
    responses,
)
from service.jobs.download_names import result_stem
from service.jobs.lookup import (
    JobId,
    check_ended,
    job_with_result,
    json_answer,
    open_result,
    result_expired,
)

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

ERRORS: Final = responses(
    JobNotFound,
    JobExpired,
    ResultNotReady,
    JobWithoutResult,
    ResultExpired,
    ContentLost,
    InvalidRequest,
)
BYTES: Final = "application/octet-stream"

_Result: TypeAlias = Annotated[
    MatchResult
    | BatchResult
    | DissimilarityResult
    | PrototypeResult
    | TransferResult
    | RegistrationResult
    | ConsistentMapsResult,
    Field(discriminator="kind"),
]


@router.get(
    "/{job_id}/result",
    response_model=_Result,
    responses=ERRORS,
    operation_id="get_result",
)
def get_result(job_id: JobId, service: ServiceOf, accept_encoding: AcceptEncoding = "") -> Response:
    """Return the result of a job.

    It is a match, the matches of a batch, the dissimilarities of a collection, a prototype, the
    values of a transfer, a template registered to specimens, or consistent maps of a collection, as
    `kind` says. Results of earlier versions have no `kind` and no `job`: until they expire, see the
    `kind` of the job.
    """
    return json_answer(open_result(service, job_id), accept_encoding)


@router.delete(
    "/{job_id}/result",
    status_code=204,
    response_class=Response,
    responses=responses(
        JobNotFound, JobExpired, ResultNotReady, JobWithoutResult, ResultExpired, InvalidRequest
    ),
    operation_id="delete_result",
)
def delete_result(job_id: JobId, service: ServiceOf) -> None:
    """Delete the result of a job that has ended, with its arrays, pictures and files.

    The job itself stays. With the result of a batch those of its matches are deleted.
    """
    record = job_with_result(service, job_id)
    if not record.state.ended:
        raise ResultNotReady(f"The job is {record.state.value}; cancel it, or wait for its end.")
    names = [job_id]
    if isinstance(record.payload, BatchPayload):
        names += [one.job for one in service.queue.batches.matches(record) if one.job is not None]
    if not service.store.results.delete(*names):
        raise result_expired()


@router.get(
    "/{job_id}/result.npz",
    response_class=Response,
    responses={200: binary_file("The arrays"), **ERRORS},
    operation_id="get_arrays",
)
def get_arrays(job_id: JobId, service: ServiceOf) -> Response:
    """Return a result as NumPy arrays in full precision, in an archive (npz) read without pickle.

    For dissimilarities: `shapes`, `names` and `labels`; `matrix` (K, K); `lower_bounds` and
    `certified` of the pairs (0, 1), (0, 2), ..., (1, 2), ...; `nearest`, the indices of each
    shape's nearest neighbours. For a match: `source`, `target` and `costs` of the pairs;
    `unmatched`; and, if requested, `dense_source`, `dense_target`, `dense_faces` and
    `dense_barycentric`, the last to four decimals, the other direction as `inverse_target`,
    `inverse_source`, `inverse_faces` and `inverse_barycentric`, `refined_vertices` and
    `refined_weights`. For a transfer: an array for each attribute, row i of vertex i of the
    target's file; `joint_names` of the columns of skinning `weights`, and `joint_parents`, their
    columns, -1 for none; of landmarks `vertices` and `weights`. For a registration: `shapes` (M,)
    of the specimens registered, `faces` (F, 3), `positions` (M, W, 3) of the template on each, row
    i of vertex i of the template's file, `mean` (W, 3), `components` (C, W, 3), `variances` (C,),
    `explained` (C,) and `scores` (M, C). For consistent maps: `shapes` (N,), and `map_I_J` (V,) for
    the places I, J of each mapped pair, both ways: row v is the vertex of the file of shape J that
    vertex v of the file of shape I goes to, -1 for vertices that are not matched.
    """
    record = job_with_result(service, job_id)
    if not record.kind.has_arrays:
        raise JobWithoutResult(
            f"A job of kind {record.kind.value!r} has no arrays; ask for its result."
        )
    check_ended(record)
    arrays = service.store.results.open_arrays(job_id)
    if arrays is None:
        raise result_expired()
    return file_response(arrays, BYTES, attachment(result_stem(service, job_id), "npz"))
