"""Exception handlers: every error of the application is answered with a problem document."""

from typing import Final

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from redis.exceptions import RedisError
from starlette.exceptions import HTTPException
from starlette.routing import Match

from broker.blobs import BlobError, BlobLost, BlobsFull, NotMigrated, no_space_left
from broker.contracts import URN, Problem
from broker.store import KeyReused, NewerRecord, NotOnDisk, QuotaExceeded, TooManyQueued
from broker.telemetry import logger
from service.http.problem_documents import response
from service.http.problems import (
    INVALID,
    ApiProblem,
    BadRequest,
    ContentLost,
    IdempotencyKeyReused,
    InvalidRequest,
    MethodNotAllowed,
    NewerVersion,
    NotFound,
    QuotaUsedUp,
    StorageFull,
    StoreAway,
    TooManyJobs,
    UnsupportedFormat,
)
from service.http.validation_errors import (
    MOST_FIELDS,
    field_problems,
    is_not_json,
    json_error,
    sent_as,
    unreadable_body,
)

_METHODS: Final = ("DELETE", "GET", "HEAD", "OPTIONS", "PATCH", "POST", "PUT")

log = logger("isomatch.api")


def install(app: FastAPI) -> None:
    """Install the handlers in an application."""
    app.add_exception_handler(ApiProblem, _refused)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(RedisError, _store_away)
    app.add_exception_handler(BlobError, _blobs_fail)
    app.add_exception_handler(OSError, _system)
    app.add_exception_handler(KeyReused, _key_reused)
    app.add_exception_handler(TooManyQueued, _too_many)
    app.add_exception_handler(QuotaExceeded, _used_up)
    app.add_exception_handler(NewerRecord, _newer)


def _refused(request: Request, error: Exception) -> Response:
    assert isinstance(error, ApiProblem)
    return response(error.problem(request.url.path), dict(error.headers))


def _key_reused(request: Request, error: Exception) -> Response:
    detail = "This Idempotency-Key was used for a different request; use a new one."
    return _refused(request, IdempotencyKeyReused(detail))


def _too_many(request: Request, error: Exception) -> Response:
    assert isinstance(error, TooManyQueued)
    jobs = "validations of uploads" if error.record.is_upload else "jobs"
    detail = f"You have {error.limit} queued {jobs}, the most allowed; wait until some have begun."
    if error.of_tenant:
        detail = (
            f"Your tenant has {error.limit} {jobs} queued or running, the most allowed; wait until"
            " some have ended."
        )
    return _refused(request, TooManyJobs(detail))


def _used_up(request: Request, error: Exception) -> Response:
    assert isinstance(error, QuotaExceeded)
    return _refused(request, QuotaUsedUp(error.detail))


def _newer(request: Request, error: Exception) -> Response:
    detail = (
        "A newer version of the service stored this; ask again when all processes are upgraded."
    )
    return _refused(request, NewerVersion(detail))


def _invalid(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    path = request.url.path
    errors = error.errors()
    broken = json_error(errors)
    if broken is not None:
        return response(BadRequest(unreadable_body(request, broken)).problem(path))
    if is_not_json(request, errors):
        wanted = sent_as(request, "send a JSON object as application/json")
        return response(UnsupportedFormat(wanted).problem(path))
    fields = field_problems(errors)
    detail = INVALID
    if len(fields) > MOST_FIELDS:
        detail += f" The first {MOST_FIELDS} of {len(fields)} fields are named."
    return response(InvalidRequest(detail, fields[:MOST_FIELDS]).problem(path))


def _http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    if no_space_left(error.__cause__):
        # The framework reads a form into temporary files, and reports what fails then as a 400.
        return _system(request, error.__cause__)
    path = request.url.path
    headers = dict(error.headers or {})
    kinds: dict[int, ApiProblem] = {
        400: BadRequest(unreadable_body(request, str(error.detail))),
        404: NotFound(f"There is nothing at {path}; /docs lists the addresses."),
        405: MethodNotAllowed(f"{request.method} is not supported at {path}."),
    }
    if error.status_code == MethodNotAllowed.type.status:
        # Starlette names only the methods of the first route with this path.
        headers["Allow"] = ", ".join(_methods_at(request))
    known = kinds.get(error.status_code)
    if known is not None:
        return response(known.problem(path), headers)
    detail = str(error.detail)
    stated = Problem(
        type=URN + "http-error",
        title=detail,
        status=error.status_code,
        detail=detail,
        instance=path,
        errors=(),
    )
    return response(stated, headers)


def _methods_at(request: Request) -> list[str]:
    def answered(method: str) -> bool:
        scope = {**request.scope, "method": method}
        return any(route.matches(scope)[0] is Match.FULL for route in request.app.routes)

    # HEAD is answered wherever GET is.
    return [m for m in _METHODS if answered(m) or (m == "HEAD" and answered("GET"))]


def _store_away(request: Request, error: Exception) -> Response:
    log.error("store cannot be reached", error=str(error))
    detail = "The store cannot be reached at the moment; try again later."
    if isinstance(error, NotOnDisk):
        detail = (
            "The request could not be made safe against a failure in time; send it again, with"
            " the same Idempotency-Key if it has one."
        )
    problem = StoreAway(detail)
    return response(problem.problem(request.url.path), {"Retry-After": "5"})


def _blobs_fail(request: Request, error: Exception) -> Response:
    log.error("the blob store failed", error=str(error))
    problem: ApiProblem
    match error:
        case BlobsFull():
            problem = StorageFull("There is no space left to store this; try again later.")
        case BlobLost():
            detail = f"The stored content is {error.reason}; delete it, and upload or request it"
            problem = ContentLost(f"{detail} again.")
        case NotMigrated():
            problem = StoreAway(
                "This was stored by an earlier version, and is not migrated yet; try again later."
            )
        case _:
            detail = "The store of meshes and results cannot be reached at the moment"
            problem = StoreAway(f"{detail}; try again later.")
    headers = dict(problem.headers)
    if problem.type.status == StoreAway.type.status:
        headers["Retry-After"] = "5"
    return response(problem.problem(request.url.path), headers)


def _system(request: Request, error: Exception) -> Response:
    if not no_space_left(error):
        raise error
    log.error("no space left for uploads", error=str(error))
    return _refused(request, StorageFull("There is no space left to take this; try again later."))
