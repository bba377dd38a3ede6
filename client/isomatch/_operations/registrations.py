"""Operations that register templates."""

import os
from collections.abc import Iterable
from pathlib import Path

from isomatch._http import Json, Operation
from isomatch._models import JobRecord, Shape
from isomatch._operations.jobs import start_job
from isomatch._operations.request_parts import id_of, listed, named, names_of
from isomatch._operations.result_files import SURFACES, check_folder
from isomatch._operations.results import get_file
from isomatch._webhooks import Webhook


def start_registration(
    template: Shape | str,
    shapes: Iterable[Shape | str],
    *,
    scale: bool,
    largest_component: bool,
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue the registration of a template to specimens."""
    every = listed(shapes, "shapes")
    body: dict[str, Json] = {
        "template": id_of(template),
        "shapes": [id_of(one) for one in every],
        "names": names_of(every),
        **named(template_name=template),
    }
    parameters = {"scale": scale, "largest_component": largest_component}
    return (yield from start_job("/v1/registrations", body, parameters, webhook, key))


def save_registered(job_id: str, path: str | os.PathLike[str], specimen: int) -> Operation[None]:
    """Request a registered template in the format that a file's name ends in, and write it."""
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending not in SURFACES:
        raise ValueError(f"{ending or Path(path).name!r} is none of {', '.join(SURFACES)}")
    check_folder(path)
    registered = yield from get_file(job_id, f"registered.{ending}", {"specimen": specimen})
    Path(path).write_bytes(registered)
