"""Ids and names as requests give them."""

import re
from collections.abc import Callable, Sequence
from pathlib import PureWindowsPath
from typing import Annotated, Final, TypeVar

from pydantic import AfterValidator, Field, ValidationInfo

from broker.contracts import file_type_of

ID_PATTERN: Final = r"^[0-9a-zA-Z_-]{1,64}$"
"""Ids of shapes, prototypes and jobs."""

NamedId = Annotated[str, Field(pattern=ID_PATTERN)]
"""An id in the body of a request."""

LONGEST: Final = 200
"""Characters of a name."""

_UNSHOWABLE: Final = re.compile(
    "[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""Control characters, line breaks, marks of writing direction, and lone surrogates."""


def without_ending(name: str) -> str:
    """Return the name of a file without the ending of its format, if that is one of meshes."""
    file_type = file_type_of(name)
    return name if file_type is None else name[: -len(file_type) - 1]


def showable(name: str) -> str:
    """Return a name unchanged if it can be shown as one line of text.

    Raises
    ------
    ValueError
        It has control characters or line breaks.
    """
    if _UNSHOWABLE.search(name):
        raise ValueError("Input should be one line of text, without control characters")
    return name


ShapeName = Annotated[str, Field(min_length=1, max_length=LONGEST), AfterValidator(showable)]
"""The name of a shape in a result."""


ListT = TypeVar("ListT", bound=Sequence[object] | None)


def one_for_each(what: str, others: str) -> Callable[[ListT, ValidationInfo], ListT]:
    """Return a validator of a list that is to have an entry for each item of an earlier field.

    Parameters
    ----------
    what
        Name of an entry, such as "name".
    others
        Name of an item, such as "shape", of the field "shapes".

    Returns
    -------
    Raises ValueError where the lists differ in length, unless the earlier one is invalid itself.
    """

    def validate(given: ListT, info: ValidationInfo) -> ListT:
        items = info.data.get(f"{others}s")
        if given is not None and items is not None and len(given) != len(items):
            raise ValueError(
                f"Input should have a {what} for each {others}: {len(items)}, not {len(given)}"
            )
        return given

    return validate


def base_name(path: str) -> str:
    """Return the last part of an uploaded file's path, without characters that cannot be shown."""
    # Browsers escape these three, and not the % itself (WHATWG HTML, multipart/form-data).
    for escaped, character in (("%22", '"'), ("%0A", "\n"), ("%0D", "\r")):
        path = path.replace(escaped, character)
    return PureWindowsPath(_UNSHOWABLE.sub("", path)).name
