"""Problem documents (RFC 9457) as HTTP responses and as OpenAPI entries."""

from typing import Any, Final

from fastapi.responses import Response

from broker.contracts import Problem
from service.http.problems import ApiProblem, InternalError, StoreAway

MEDIA_TYPE: Final = "application/problem+json"


def responses(*kinds: type[ApiProblem]) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI entries of the problems that an operation may answer with."""
    entries: dict[int | str, dict[str, Any]] = {}
    every: tuple[type[ApiProblem], ...] = (*kinds, InternalError, StoreAway)
    for kind in every:
        text = (kind.__doc__ or kind.type.title).strip().splitlines()[0].rstrip(".")
        example = kind(text + ".").problem("/v1/...").model_dump(mode="json")
        entry = entries.setdefault(
            kind.type.status,
            {
                "description": "",
                "content": {
                    MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}, "examples": {}}
                },
            },
        )
        entry["description"] += ("; " if entry["description"] else "") + text
        entry["content"][MEDIA_TYPE]["examples"][kind.type.slug] = {"value": example}
    return entries


def binary_file(
    description: str, *media_types: str, headers: dict[str, Any] | None = None
) -> dict[str, Any]:
    """Return the OpenAPI entry of an answer that is a file, by default of bytes."""
    content = {"schema": {"type": "string", "format": "binary"}}
    entry = {
        "description": description,
        "content": dict.fromkeys(media_types or ("application/octet-stream",), content),
    }
    return entry if headers is None else {**entry, "headers": headers}


def response(problem: Problem, headers: dict[str, str] | None = None) -> Response:
    """Return the HTTP response of a problem document."""
    return Response(
        problem.model_dump_json(),
        status_code=problem.status,
        media_type=MEDIA_TYPE,
        headers=headers,
    )
