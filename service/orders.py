"""How requests ask for jobs: what every such endpoint takes from its request, and answers."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Final
from urllib.parse import urlsplit

from fastapi import Depends, Header, Request, Response
from pydantic import AfterValidator, BaseModel, Field

from broker.contracts import (
    FieldProblem,
    IdempotencyRecord,
    JobRecord,
    PrototypeRecord,
    RequestContext,
    ShapeRecord,
    Webhook,
)
from broker.webhooks import literal_address, permitted
from service.http import (
    ApiProblem,
    BadRequest,
    BodyStalled,
    EncodedBody,
    IdempotencyKeyReused,
    InvalidRequest,
    TooManyJobs,
    UnknownPrototype,
    UnknownShape,
    UploadTooLarge,
    responses,
)
from service.job_schema import Job
from service.state import Caller, RequestId, Service, ServiceOf

LONGEST_KEY: Final = 255

_ACCEPTED: Final[dict[str, Any]] = {
    "description": "The job, which the workers take up",
    "headers": {"Location": {"description": "The job.", "schema": {"type": "string"}}},
}


def answers(*further: type[ApiProblem]) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI entries of the answers to a request for a job.

    Parameters
    ----------
    further
        What such a request may be refused for besides what every one may.
    """
    return {
        202: _ACCEPTED,
        **responses(
            InvalidRequest,
            UnknownShape,
            *further,
            BadRequest,
            UploadTooLarge,
            BodyStalled,
            EncodedBody,
            IdempotencyKeyReused,
            TooManyJobs,
        ),
    }


def _printable(key: str) -> str:
    if not key.isascii() or not key.isprintable():
        raise ValueError("Input should be printable ASCII")
    return key


IdempotencyKey = Annotated[
    Annotated[str, AfterValidator(_printable)] | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=LONGEST_KEY,
        description="A name of your own for this request: sent again with the same key, it makes"
        " no second job but answers with the first one. The same key with another request is"
        " refused (409). Keys are remembered for a day unless the service is set up otherwise.",
    ),
]


async def _order(
    request: Request,
    service: ServiceOf,
    request_id: RequestId,
    caller: Caller,
    key: IdempotencyKey = None,
) -> RequestContext:
    idempotency = None
    if key is not None:
        content = (request.method.encode(), request.url.path.encode(), await request.body())
        idempotency = IdempotencyRecord.of(caller, key, content, service.settings.idempotency_ttl)
    return RequestContext(request_id, caller, idempotency)


JobOrder = Annotated[RequestContext, Depends(_order)]
"""How a request with a body of JSON asks for its job."""


def accepted(record: JobRecord, service: Service, response: Response) -> Job:
    """Return the job a request asked for, with its address in the answer's header."""
    job = Job.of(record, service.queue)
    response.headers["Location"] = job.links.self
    return job


class JobRequest(BaseModel):
    """What requests of every kind of job may say besides what the job is to do."""

    webhook: Webhook | None = Field(
        default=None, description="Whom to tell when the job has ended; null for nobody."
    )


def told_to(service: Service, asked: JobRequest, order: RequestContext) -> RequestContext:
    """Return an order whose job's end is told to whom the request names.

    Raises
    ------
    InvalidRequest
        That is an address which webhooks may not go to. (What a name stands for is seen when it
        is told.)
    """
    if asked.webhook is None:
        return order
    host = urlsplit(asked.webhook.url).hostname or ""
    address = literal_address(host)
    if address is not None and not permitted(address, service.settings.webhook_networks):
        message = f"{host} is no public address, and this service does not allow it"
        fields = (FieldProblem(field="body.webhook.url", message=message),)
        raise InvalidRequest("The request is not valid; `errors` says where.", fields)
    return replace(order, webhook=asked.webhook)


def use_shapes(service: Service, named: Mapping[str, str]) -> dict[str, ShapeRecord]:
    """Keep the shapes that a request names for longer, which are needed when its job is begun.

    Parameters
    ----------
    service
        Where they are.
    named
        Ids of the shapes by the fields that name them, such as ``body.source``.

    Returns
    -------
    Their records, by the same fields.

    Raises
    ------
    UnknownShape
        There is no such shape, or no longer.
    """
    shapes = service.store.shapes
    found = {field: shapes.use(shape) for field, shape in named.items()}
    unknown = tuple(
        FieldProblem(
            field=field,
            message=f"shape {shape} was not used for long and is no longer kept; upload it again"
            if shapes.expired(shape)
            else f"there is no shape {shape}",
        )
        for field, shape in named.items()
        if found[field] is None
    )
    if unknown:
        raise UnknownShape("Upload the shapes first; `errors` says which is unknown.", unknown)
    return {field: record for field, record in found.items() if record is not None}


def use_prototype(service: Service, field: str, prototype: str) -> PrototypeRecord:
    """Keep the prototype that a request names for longer, as :func:`use_shapes`.

    Parameters
    ----------
    service
        Where it is.
    field
        What names it, such as ``body.source``.
    prototype
        Its id.

    Raises
    ------
    UnknownPrototype
        There is no such prototype, or no longer.
    """
    record = service.store.prototypes.use(prototype)
    if record is not None:
        return record
    message = f"there is no prototype {prototype}"
    if service.store.prototypes.expired(prototype):
        message = (
            f"prototype {prototype} was not used for long and is no longer kept; learn it or"
            " upload it again"
        )
    fields = (FieldProblem(field=field, message=message),)
    raise UnknownPrototype("Learn or upload the prototype first.", fields)
