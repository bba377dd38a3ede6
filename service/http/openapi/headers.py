"""Headers of answers in the OpenAPI document: those that middleware and error handlers set."""

from typing import Any, Final

_HEADERS: Final[dict[str, str]] = {
    "X-Request-ID": "Id of the request: the one it gave, or a new one. Logs have it, too.",
    "Retry-After": "Seconds after which to ask again; missing where time alone does not help.",
    "WWW-Authenticate": "The scheme of the API key, `Bearer`.",
    "Content-Disposition": "Name of the file.",
    "ETag": "Version of the content, weak, for `If-None-Match`.",
}

NAMED_FILES: Final = frozenset(
    {
        "get_mesh",
        "get_archive",
        "get_arrays",
        "get_export",
        "get_map",
        "get_registered_template",
        "get_source_arrays",
    }
)
"""Operations whose answer is a file with a name."""

_BY_STATUS: Final[dict[str, str]] = {
    "304": "ETag",
    "401": "WWW-Authenticate",
    "429": "Retry-After",
    "503": "Retry-After",
    "507": "Retry-After",
}


def declare_headers(schema: dict[str, Any]) -> None:
    """Declare the headers of all answers in an OpenAPI document."""
    schema["components"]["headers"] = {
        name: {"description": text, "schema": {"type": "string"}} for name, text in _HEADERS.items()
    }
    for calls in schema["paths"].values():
        for call in calls.values():
            for status, answer in call["responses"].items():
                headers = answer.setdefault("headers", {})
                for name in _names(call["operationId"], status):
                    headers[name] = {"$ref": f"#/components/headers/{name}"}


def _names(operation: str, status: str) -> list[str]:
    names = ["X-Request-ID"]
    if status in _BY_STATUS:
        names.append(_BY_STATUS[status])
    if status == "200" and operation in NAMED_FILES:
        names.append("Content-Disposition")
    if status == "202" and not operation.startswith("create_"):
        names.append("Retry-After")  # an upload is still being validated
    return names
