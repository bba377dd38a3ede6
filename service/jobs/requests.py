"""Requests for jobs: idempotency keys, webhooks, and the answers common to all of them."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Final, TypeVar
from urllib.parse import urlsplit

from fastapi import Depends, Header, Request, Response
from pydantic import AfterValidator, BaseModel, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from broker.contracts import (
    BoundedModel,
    FieldProblem,
    IdempotencyRecord,
    Payload,
    RequestOrigin,
    Webhook,
)
from broker.webhooks import literal_address, permitted
from service.dependencies import Caller, RequestId, Service, ServiceOf
from service.http import (
    INVALID,
    ApiProblem,
    BadRequest,
    BodyStalled,
    EncodedBody,
    IdempotencyKeyReused,
    InvalidRequest,
    QuotaUsedUp,
    TooManyJobs,
    UnknownShape,
    UnsupportedFormat,
    UploadTooLarge,
    responses,
)
from service.jobs.schemas import Job

ParametersT = TypeVar("ParametersT", bound=BaseModel)
RequestT = TypeVar("RequestT", bound="JobRequest")

LONGEST_KEY: Final = 255
"""Characters of an idempotency key."""

_REPLAYED: Final = "Idempotency-Replayed"

_ACCEPTED: Final[dict[str, Any]] = {
    "description": "The queued job",
    "headers": {
        "Location": {"description": "The job.", "schema": {"type": "string"}},
        _REPLAYED: {
            "description": "Where the `Idempotency-Key` was used before, and this is its job.",
            "schema": {"const": "true"},
        },
    },
}


def answers(*further: type[ApiProblem]) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI entries of the answers to a request for a job.

    Parameters
    ----------
    further
        Problems besides those of every such request.
    """
    return {
        202: _ACCEPTED,
        **responses(
            InvalidRequest,
            UnknownShape,
            *further,
            BadRequest,
            UploadTooLarge,
            UnsupportedFormat,
            BodyStalled,
            EncodedBody,
            IdempotencyKeyReused,
            TooManyJobs,
            QuotaUsedUp,
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
        description="A unique name that the client gives this request. Sent again with the same"
        " key, it makes no second job and is answered with the first one. The same key with a"
        " different request is refused (409). Keys are remembered for a day by default.",
    ),
]


_ABOUT: Final = ("title", "description", "default", "examples", "deprecated")
"""Keywords of a JSON schema that are about a field, and not about its values."""


def _nullable(field: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON schema of a field that may also be null."""
    if {"type": "null"} in field.get("anyOf", ()):
        return field
    about = {name: value for name, value in field.items() if name in _ABOUT}
    values = {name: value for name, value in field.items() if name not in _ABOUT}
    return {"anyOf": [values, {"type": "null"}], **about}


class JobRequest(BoundedModel):
    """Fields of the requests for all kinds of jobs. Null stands for a field that is left out."""

    webhook: Webhook | None = Field(
        default=None,
        description="Receiver of a notification when the job has ended, or null.",
    )

    @model_validator(mode="before")
    @classmethod
    def _without_nulls(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        optional = cls._optional()
        return {
            name: given
            for name, given in value.items()
            if given is not None or name not in optional
        }

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the JSON schema, in which fields that may be left out may be null."""
        described = handler(schema)
        properties = handler.resolve_ref_schema(described)["properties"]
        for name in cls._optional():
            properties[name] = _nullable(properties[name])
        return described

    def parameters(self, kind: type[ParametersT]) -> ParametersT:
        """Return those of its fields that are parameters of a kind."""
        return kind.model_construct(**{name: getattr(self, name) for name in kind.model_fields})

    @classmethod
    def _optional(cls) -> list[str]:
        return [name for name, field in cls.model_fields.items() if not field.is_required()]


def _check_webhook(service: Service, webhook: Webhook) -> None:
    """Refuse a webhook whose host is an IP address that is not permitted, or no host name.

    Host names are resolved and checked at delivery.

    Raises
    ------
    InvalidRequest
        It is one of these.
    """
    host = urlsplit(webhook.url).hostname or ""
    address, message = literal_address(host), None
    if address is not None and not permitted(address, service.settings.webhook_networks):
        message = f"{host} is not a public address; this service does not permit it"
    elif not _is_host_name(host):
        message = "the parts of a host name between dots have 1 to 63 characters"
    if message is not None:
        fields = (FieldProblem(field="body.webhook.url", message=message),)
        raise InvalidRequest(INVALID, fields)


def _is_host_name(host: str) -> bool:
    """Return whether a host can be resolved: the standard library encodes it so first."""
    try:
        host.encode("idna")
    except UnicodeError:
        return False
    return True


@dataclass(frozen=True)
class JobOrder:
    """A request for a job, with a JSON body.

    Parameters
    ----------
    service
        The service that queues it.
    origin
        Its id, caller and idempotency key.
    response
        The answer, whose headers are set.
    """

    service: Service
    origin: RequestOrigin
    response: Response

    def job(self, asked: RequestT, payload_of: Callable[[RequestT, Service], Payload]) -> Job:
        """Return the job that the request makes, or made before with the same idempotency key.

        Parameters
        ----------
        asked
            The body of the request.
        payload_of
            Checks the body, and returns the payload of its job.

        Raises
        ------
        NotOnDisk
            The job may be lost if Redis is killed now; the same request with the same idempotency
            key is answered with it, or queues it again.
        """
        service = self.service
        record, replayed = service.queue.earlier_job(self.origin), True
        if record is None:
            if asked.webhook is not None:
                _check_webhook(service, asked.webhook)
            origin = replace(self.origin, webhook=asked.webhook)
            payload = payload_of(asked, service)
            record, replayed = service.queue.submit_or_replay(payload, origin)
        if replayed:
            self.response.headers[_REPLAYED] = "true"
        service.store.jobs.wait_for_disk(record.id)
        job = Job.of(record, service.queue)
        self.response.headers["Location"] = job.links.self
        return job


async def _order(
    request: Request,
    response: Response,
    service: ServiceOf,
    request_id: RequestId,
    caller: Caller,
    key: IdempotencyKey = None,
) -> JobOrder:
    once = None
    if key is not None:
        content = (request.method.encode(), request.url.path.encode(), await request.body())
        once = IdempotencyRecord.of(caller, key, content, service.settings.idempotency_ttl)
    return JobOrder(service, RequestOrigin(request_id, caller, once), response)


JobOrderOf = Annotated[JobOrder, Depends(_order)]
