"""Validation errors of Pydantic as problems of fields."""

import re
from collections.abc import Sequence
from typing import Any, Final

from fastapi import Request

from broker.contracts import FieldProblem, json_pointer

MOST_FIELDS: Final = 20
"""Fields named in one answer, so that it is not many times as long as the request."""

_LONGEST_FIELD: Final = 100
"""Characters of the name of a field."""

_BRANCH: Final = re.compile(r"(literal|tuple|choice)\[.*\]", re.DOTALL)
"""Parts of an error's location that name the branch of a union, and no field."""

_NOT_AN_OBJECT: Final = ("missing", "model_attributes_type", "model_type", "dict_type")
_BOUNDS: Final = {
    "greater_than": ("gt", "greater than"),
    "greater_than_equal": ("ge", "greater than or equal to"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "less than or equal to"),
}
"""Bounds are formatted here, as Pydantic writes 1e30 with all its zeros."""

_POSITIVE: Final = 1e-20
"""Lower bounds up to this stand for positive numbers, within what floating point can compute."""

_LENGTHS: Final = {"too_short": ("at least", "min_length"), "too_long": ("at most", "max_length")}
_WORDS: Final = {
    "extra_forbidden": "There is no such field; /docs lists the fields",
    "tuple_type": "Input should be a list",
    "upload_file": "Input should be a file: a part of the form that has a `filename`",
    "no_file": "The form has no such part, or is truncated; send multipart/form-data with a part"
    " `file` that has a `filename`",
    "not_an_object": "Input should be a JSON object, sent as application/json",
}


def field_problems(errors: Sequence[Any]) -> tuple[FieldProblem, ...]:
    """Return the problems of fields, each field once.

    Parameters
    ----------
    errors
        As Pydantic lists them.
    """
    messages: dict[tuple[str, ...], list[str]] = {}
    # Pydantic counts only valid items: it reports a list with an invalid one as too short as well.
    lists = {error["loc"][:-1] for error in errors}
    for error in errors:
        if error["type"] == "too_short" and error["loc"] in lists:
            continue
        address = tuple(part for part in map(str, error["loc"]) if not _BRANCH.fullmatch(part))
        said = messages.setdefault(address, [])
        message = _message(error)
        if message not in said:
            said.append(message)
    return tuple(_problem(address, "; ".join(said)) for address, said in messages.items())


def _problem(address: Sequence[str], message: str) -> FieldProblem:
    field = ".".join(address)
    if len(field) > _LONGEST_FIELD:
        return FieldProblem(field=short(field), message=message, pointer=None)
    if address[0] != "body":
        return FieldProblem(field=field, message=message)
    # The names of unknown fields may have dots.
    return FieldProblem(field=field, message=message, pointer=json_pointer(address[1:]))


def json_error(errors: Sequence[Any]) -> str | None:
    """Return the position and cause of a syntax error in the JSON body, if there is one."""
    for error in errors:
        if error["type"] == "json_invalid":
            return f"{error['ctx']['error']} at character {error['loc'][-1]}"
    return None


def media_type(content_type: str | None) -> str:
    """Return the media type of a header ``Content-Type``, without parameters."""
    return (content_type or "").partition(";")[0].strip().lower()


def sent_as(request: Request, wanted: str) -> str:
    """Return the detail of the problem that a body is of another type than is wanted.

    Parameters
    ----------
    request
        The request.
    wanted
        What to do.
    """
    given = media_type(request.headers.get("content-type"))
    return f"The body was sent as {short(given)}; {wanted}."


def is_not_json(request: Request, errors: Sequence[Any]) -> bool:
    """Return whether a body that is no JSON object was sent as something else than JSON."""
    given = media_type(request.headers.get("content-type"))
    wrong = any(
        tuple(error["loc"]) == ("body",) and error["type"] in _NOT_AN_OBJECT for error in errors
    )
    return wrong and given not in ("", "application/json") and not given.endswith("+json")


def unreadable_body(request: Request, reason: str) -> str:
    """Return the detail of the problem that a body cannot be parsed.

    Parameters
    ----------
    request
        The request.
    reason
        Message of the parser.
    """
    if media_type(request.headers.get("content-type")) == "multipart/form-data":
        wanted = "send multipart/form-data with the mesh as `file`, a part with a `filename`"
    else:
        wanted = "send a JSON object in UTF-8, without deep nesting or numbers of very many digits"
    return f"The body cannot be read ({reason.rstrip('.')}); {wanted}."


def _message(error: Any) -> str:
    kind = error["type"]
    if kind in _LENGTHS and isinstance(error["ctx"].get("actual_length"), int):
        words, key = _LENGTHS[kind]
        count = error["ctx"][key]
        noun = "character" if isinstance(error["input"], str) else "item"
        noun += "" if count == 1 else "s"
        return f"Input should have {words} {count} {noun}, not {error['ctx']['actual_length']}"
    if kind in _BOUNDS:
        key, words = _BOUNDS[kind]
        bound = error["ctx"][key]
        if (
            kind == "greater_than_equal"
            and 0.0 < bound < _POSITIVE
            and float(error["input"]) <= 0.0
        ):
            return "Input should be greater than 0"
        return f"Input should be {words} {bound:g}"
    if kind == "tuple_type" and "landmarks" in error["loc"]:
        wanted = "a list of pairs" if error["loc"][-1] == "landmarks" else "a pair"
        return f"Input should be {wanted} [vertex of the source, vertex of the target]"
    if kind in _NOT_AN_OBJECT and tuple(error["loc"]) == ("body",):
        kind = "not_an_object"
    elif kind == "missing" and tuple(error["loc"]) == ("body", "file"):
        kind = "no_file"
    elif "UploadFile" in error["msg"]:
        kind = "upload_file"
    return _WORDS.get(kind) or str(error["msg"]).removeprefix("Value error, ")


def short(field: str) -> str:
    """Return the name of a field, cut if it is long."""
    return field if len(field) <= _LONGEST_FIELD else field[: _LONGEST_FIELD - 3] + "..."
