"""Operations on prototypes."""

import operator
import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import SupportsIndex

import numpy as np

from isomatch._errors import UnexpectedResponse
from isomatch._http import Call, Json, Operation, fetch, fetch_bytes, send
from isomatch._models import JobRecord, PrototypeParameters, Shape, check_names
from isomatch._operations.jobs import start_job
from isomatch._operations.request_parts import id_of, listed, path_to
from isomatch._results import Prototype, PrototypePoints
from isomatch._webhooks import Webhook


def start_prototype(
    shapes: Iterable[Shape | str],
    correspondences: Iterable[Iterable[SupportsIndex]] | None,
    *,
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
        body["correspondences"] = [list(map(operator.index, one)) for one in correspondences]
    if name is not None:
        body["name"] = name
    if reference is not None:
        body["reference"] = id_of(reference)
    return (yield from start_job("/v1/prototypes", body, parameters, webhook, key))


def download_prototype(prototype: Prototype | str, path: str | os.PathLike[str]) -> Operation[None]:
    """Request the archive of a prototype, and write it to a file."""
    content = yield from fetch_bytes(path_to("prototypes", prototype, "archive"))
    Path(path).write_bytes(content)


def get_prototype_points(prototype: Prototype | str) -> Operation[PrototypePoints]:
    """Request the archive of a prototype and its view, and read its points."""
    path = path_to("prototypes", prototype)
    known = prototype if isinstance(prototype, Prototype) else (yield from fetch(Prototype, path))
    response = yield from send(Call("GET", f"{path}/archive"))
    try:
        return replace(PrototypePoints.from_bytes(response.content), view=np.array(known.view))
    except ValueError as error:
        raise UnexpectedResponse(f"{response.request.url}: {error}") from error
