"""Operations on prototypes."""

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from isomatch._errors import UnexpectedResponse
from isomatch._http import Call, Json, Operation, delete, parsed, send
from isomatch._models import JobRecord, Page, PrototypeParameters, Shape, check_names
from isomatch._operations.jobs import start_job
from isomatch._operations.request_parts import id_of, listed, path_to
from isomatch._operations.uploads import upload
from isomatch._results import Prototype, PrototypePoints
from isomatch._upload import FileSource, prototype_file
from isomatch._webhooks import Webhook


def start_prototype(
    shapes: Iterable[Shape | str],
    correspondences: Iterable[Iterable[int]] | None,
    name: str | None,
    reference: Shape | str | None,
    parameters: PrototypeParameters,
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue the learning of a prototype."""
    check_names(parameters, PrototypeParameters.__annotations__, "learn_prototype")
    body: dict[str, Json] = {"shapes": [id_of(one) for one in listed(shapes, "shapes")]}
    if correspondences is not None:
        body["correspondences"] = [[int(vertex) for vertex in one] for one in correspondences]
    if name is not None:
        body["name"] = name
    if reference is not None:
        body["reference"] = id_of(reference)
    return (yield from start_job("/v1/prototypes", body, parameters, webhook, key))


def get_prototype(prototype_id: str) -> Operation[Prototype]:
    """Request one prototype."""
    call = Call("GET", path_to("prototypes", prototype_id))
    return parsed(Prototype, (yield from send(call)))


def list_prototypes(cursor: str | None, name: str | None) -> Operation[Page[Prototype]]:
    """Request one page of the prototypes, of all or of one name."""
    call = Call("GET", "/v1/prototypes", query={"name": name, "cursor": cursor})
    return parsed(Page[Prototype], (yield from send(call)))


def delete_prototype(prototype: Prototype | str) -> Operation[None]:
    """Delete a prototype."""
    yield from delete(path_to("prototypes", prototype))


def download_prototype(prototype: Prototype | str, path: str | os.PathLike[str]) -> Operation[None]:
    """Request the archive of a prototype, and write it to a file."""
    call = Call("GET", path_to("prototypes", prototype, "archive"))
    Path(path).write_bytes((yield from send(call)).content)


def get_prototype_points(prototype: Prototype | str) -> Operation[PrototypePoints]:
    """Request the archive of a prototype and its view, and read its points."""
    known = prototype if isinstance(prototype, Prototype) else (yield from get_prototype(prototype))
    response = yield from send(Call("GET", path_to("prototypes", prototype, "archive")))
    try:
        return replace(PrototypePoints.from_bytes(response.content), view=np.array(known.view))
    except ValueError as error:
        raise UnexpectedResponse(f"{response.request.url}: {error}") from error


def upload_prototype(
    source: FileSource, name: str | None, timeout: float | None
) -> Operation[Prototype]:
    """Upload the archive of a prototype, and wait until the service has read it.

    Raises
    ------
    WaitTimeout
        It was not read within `timeout` seconds.
    """
    file = prototype_file(source)
    answer = yield from upload("/v1/prototype-archives", file, name, timeout)
    return parsed(Prototype, answer)
