"""Prototypes as requests name them."""

from typing import Annotated, Final

from fastapi import Path

from broker.contracts import PrototypeRecord
from service.dependencies import Service
from service.http import (
    PrototypeDeleted,
    PrototypeExpired,
    PrototypeNotFound,
    UnknownPrototype,
)
from service.names import ID_PATTERN
from service.uploads import UploadKind

PrototypeId = Annotated[str, Path(description="Id of the prototype.", pattern=ID_PATTERN)]

LOCATION: Final = "/v1/prototypes"
PATH: Final = "/v1/prototype-archives"

PROTOTYPES: Final = UploadKind[PrototypeRecord](
    "prototype",
    lambda store: store.prototypes,
    "learn it or upload it again",
    PrototypeNotFound,
    PrototypeExpired,
    PrototypeDeleted,
    path=PATH,
    location=LOCATION,
)


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
    if record is None:
        wrong = PROTOTYPES.unknown(service, field, prototype)
        raise UnknownPrototype("Learn or upload the prototype first.", (wrong,))
    return record
