"""Query parameters that no address takes are refused, as unknown fields of bodies are."""

from typing import Any

from fastapi import Request

from broker.contracts import FieldProblem
from service.http.problems import INVALID, InvalidRequest
from service.http.security import PROTECTED
from service.http.validation_errors import MOST_FIELDS, short


async def known_parameters(request: Request) -> None:
    """Dependency that refuses parameters unknown to an operation under ``/v1``, and repeated ones.

    A misspelt filter or view would be answered as if it were not there, and so would the first of
    two values. The page and the probes take any: other programs decorate their addresses.

    Raises
    ------
    InvalidRequest
        The operation has no such parameter, of which the message lists those that it has; or one
        that is no list is repeated.
    """
    if not request.query_params or not request.url.path.startswith(f"{PROTECTED}/"):
        return
    path = request.scope["route"].path_format
    operation = request.app.openapi()["paths"][path][request.method.lower()]
    every = operation.get("parameters", ())
    known = sorted(one["name"] for one in every if one["in"] == "query")
    lists = {one["name"] for one in every if _is_list(one["schema"])}
    takes = f"it takes {', '.join(known)}" if known else "it takes none"
    wrong = {
        name: "The address has this parameter several times; give it once"
        if name in known
        else f"There is no such parameter at this address; {takes}"
        for name in request.query_params
        if name not in known or (name not in lists and len(request.query_params.getlist(name)) > 1)
    }
    if wrong:
        named = list(wrong.items())[:MOST_FIELDS]
        raise InvalidRequest(
            INVALID,
            tuple(FieldProblem(field=short(f"query.{name}"), message=text) for name, text in named),
        )


def _is_list(schema: dict[str, Any]) -> bool:
    return any(one.get("type") == "array" for one in schema.get("anyOf", [schema]))
