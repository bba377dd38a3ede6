"""Every error of an application, its own or its parts', told as a problem document."""

from typing import Final

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from redis.exceptions import RedisError
from starlette.exceptions import HTTPException
from starlette.routing import Match

from broker.contracts import Problem
from broker.store import KeyReused, NewerRecord, TooManyQueued
from broker.telemetry import logger
from service.http.problem_documents import response
from service.http.problems import (
    ApiProblem,
    BadRequest,
    IdempotencyKeyReused,
    InvalidRequest,
    MethodNotAllowed,
    NewerVersion,
    NotFound,
    StoreAway,
    TooManyJobs,
)
from service.http.requests import MOST_CONSIDERED, MOST_FIELDS, field_problems, no_json, unreadable

_METHODS: Final = ("DELETE", "GET", "HEAD", "OPTIONS", "PATCH", "POST", "PUT")

log = logger("isomatch.api")


def install(app: FastAPI) -> None:
    """Let every error of an application be told as a problem document."""
    app.add_exception_handler(ApiProblem, _refused)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(RedisError, _store_away)
    app.add_exception_handler(KeyReused, _key_reused)
    app.add_exception_handler(TooManyQueued, _too_many)
    app.add_exception_handler(NewerRecord, _newer)


def _refused(request: Request, error: Exception) -> Response:
    assert isinstance(error, ApiProblem)
    return response(error.problem(request.url.path), dict(error.headers))


def _key_reused(request: Request, error: Exception) -> Response:
    detail = "This Idempotency-Key came with another request before; make a new one for this."
    return _refused(request, IdempotencyKeyReused(detail))


def _too_many(request: Request, error: Exception) -> Response:
    assert isinstance(error, TooManyQueued)
    detail = (
        f"There are {error.limit} of your jobs in the queue already; wait until some have begun."
    )
    return _refused(request, TooManyJobs(detail))


def _newer(request: Request, error: Exception) -> Response:
    detail = "A newer version of the service stored this; ask again when all of it is upgraded."
    return _refused(request, NewerVersion(detail))


def _invalid(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    path = request.url.path
    errors = error.errors()
    broken = no_json(errors)
    if broken is not None:
        return response(BadRequest(unreadable(request, broken)).problem(path))
    fields = field_problems(errors)
    detail = "The request is not valid; `errors` says where."
    if len(fields) > MOST_FIELDS:
        many = "more than " if len(errors) > MOST_CONSIDERED else ""
        detail += f" The first {MOST_FIELDS} of {many}{len(fields)} fields are named."
    return response(InvalidRequest(detail, fields[:MOST_FIELDS]).problem(path))


def _http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    path = request.url.path
    headers = dict(error.headers or {})
    kinds: dict[int, ApiProblem] = {
        400: BadRequest(unreadable(request, str(error.detail))),
        404: NotFound(f"There is nothing at {path}; /docs says what there is."),
        405: MethodNotAllowed(f"{request.method} cannot be done at {path}."),
    }
    if error.status_code == MethodNotAllowed.status:
        # The router names the methods of the first route only that has this path.
        headers["Allow"] = ", ".join(_methods_at(request))
    known = kinds.get(error.status_code)
    if known is not None:
        return response(known.problem(path), headers)
    detail = str(error.detail)
    stated = Problem.of("http-error", detail, error.status_code, detail, instance=path)
    return response(stated, headers)


def _methods_at(request: Request) -> list[str]:
    def answered(method: str) -> bool:
        scope = {**request.scope, "method": method}
        return any(route.matches(scope)[0] is Match.FULL for route in request.app.routes)

    # HEAD is answered wherever GET is.
    return [m for m in _METHODS if answered(m) or (m == "HEAD" and answered("GET"))]


def _store_away(request: Request, error: Exception) -> Response:
    log.error("store cannot be reached", error=str(error))
    problem = StoreAway("The store cannot be reached just now; try again in a moment.")
    return response(problem.problem(request.url.path), {"Retry-After": "5"})
