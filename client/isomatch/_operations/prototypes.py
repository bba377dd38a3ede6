"""Operations on prototypes."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, TypeAlias

from isomatch._errors import UnexpectedResponse
from isomatch._http import Call, Json, Operation, parsed, send
from isomatch._models import JobRecord, Page, PrototypeParameters, Shape, check_names
from isomatch._operations.jobs import start_job
from isomatch._operations.request_parts import id_of, path_to
from isomatch._operations.shapes import read_upload
from isomatch._results import Prototype, PrototypePoints
from isomatch._upload import MeshFile, name_of
from isomatch._webhooks import Webhook

ArchiveSource: TypeAlias = str | os.PathLike[str] | bytes | BinaryIO
"""A path, the bytes of a file, or an open binary file."""


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
    body: dict[str, Json] = {"shapes": [id_of(shape) for shape in shapes]}
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
    yield from send(Call("DELETE", path_to("prototypes", id_of(prototype))))


def download_prototype(prototype: Prototype | str, path: str | os.PathLike[str]) -> Operation[None]:
    """Request the archive of a prototype, and write it to a file."""
    call = Call("GET", path_to("prototypes", id_of(prototype), "archive"))
    Path(path).write_bytes((yield from send(call)).content)


def get_prototype_points(prototype: Prototype | str) -> Operation[PrototypePoints]:
    """Request the archive of a prototype, and read its points."""
    response = yield from send(Call("GET", path_to("prototypes", id_of(prototype), "archive")))
    try:
        return PrototypePoints.from_bytes(response.content)
    except ValueError as error:
        raise UnexpectedResponse(f"{response.request.url}: {error}") from error


def upload_prototype(
    source: ArchiveSource, name: str | None, timeout: float | None
) -> Operation[Prototype]:
    """Upload the archive of a prototype, and wait until the service has read it.

    Raises
    ------
    WaitTimeout
        It was not read within `timeout` seconds.
    """
    with _archive_file(source) as file:
        form = {} if name is None else {"name": name}
        call = Call("POST", "/v1/prototype-archives", file=file, form=form)
        response = yield from send(call)
    return parsed(Prototype, (yield from read_upload(response, name or file.name, timeout)))


@contextmanager
def _archive_file(source: ArchiveSource) -> Iterator[MeshFile]:
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        with path.open("rb") as file:
            yield MeshFile(path.name, file)
    elif isinstance(source, bytes | bytearray | memoryview):
        yield MeshFile("prototype.npz", bytes(source))
    elif hasattr(source, "read"):
        yield MeshFile(name_of(source) or "prototype.npz", source)
    else:
        raise TypeError(
            f"a prototype is a path, bytes or an open binary file, not {type(source).__name__}"
        )
