"""Prototypes as requests name them."""

from typing import Annotated

from fastapi import Path

from broker.contracts import FieldProblem, PrototypeRecord
from service.dependencies import Service
from service.http import ApiProblem, PrototypeExpired, PrototypeNotFound, UnknownPrototype
from service.names import ID_PATTERN

PrototypeId = Annotated[str, Path(description="Id of the prototype.", pattern=ID_PATTERN)]


def missing_prototype(service: Service, prototype: str) -> ApiProblem:
    """Return the problem that a prototype is not there."""
    if service.store.prototypes.expired(prototype):
        return PrototypeExpired(
            "The prototype was not used for long and is no longer kept; learn it or upload it"
            " again."
        )
    return PrototypeNotFound(f"There is no prototype {prototype}.")


def use_prototype(service: Service, field: str, prototype: str) -> PrototypeRecord:
    """Return the prototype that a request names, and prolong its life until the job begins.

    Parameters
    ----------
    service
        The service that keeps it.
    field
        The field that names it, such as ``body.source``.
    prototype
        Its id.

    Raises
    ------
    UnknownPrototype
        There is no such prototype, or it has expired.
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
