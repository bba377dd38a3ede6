"""Where resources are, and how they and parameters are named in requests."""

from urllib.parse import quote

import numpy as np

from isomatch._http import Json
from isomatch._models import Shape
from isomatch._results import Prototype


def id_of(given: Shape | Prototype | str) -> str:
    """Return the id of a shape or a prototype that is given itself or as its id."""
    return given if isinstance(given, str) else given.id


def path_to(*parts: str) -> str:
    """Return the address of a resource."""
    return "/v1/" + "/".join(quote(part, safe="") for part in parts)


def plain(value: object) -> Json:
    """Return the value of a parameter as it is sent."""
    # Parameters often come out of an array or a linspace.
    sent: Json = value.item() if isinstance(value, np.generic) else value  # type: ignore[assignment]
    return sent
