"""Paths of resources, and ids and parameters as they are sent."""

from urllib.parse import quote

import numpy as np

from isomatch._http import Json
from isomatch._models import Shape
from isomatch._results import Prototype


def id_of(given: Shape | Prototype | str) -> str:
    """Return the id of a shape or a prototype, which may be given as its id."""
    return given if isinstance(given, str) else given.id


def path_to(*parts: str) -> str:
    """Return the path of a resource."""
    return "/v1/" + "/".join(quote(part, safe="") for part in parts)


def json_value(value: object) -> Json:
    """Return the value of a parameter as JSON; scalars of numpy become numbers of Python."""
    # Callers give JSON or scalars of numpy, which `object` does not say.
    sent: Json = value.item() if isinstance(value, np.generic) else value  # type: ignore[assignment]
    return sent
