"""Examples of all operations, and links from the answer of one to the parameters of others."""

import json
from pathlib import Path
from typing import Any, Final

EXAMPLES: Final[dict[str, Any]] = json.loads(
    Path(__file__).with_name("examples.json").read_text(encoding="utf-8")
)
"""Parameters by name, request bodies by operation, named answers by operation and status."""

_ID: Final = "$response.body#/id"
_OF_A_SHAPE: Final = {
    "get_shape": {"shape": _ID},
    "get_mesh": {"shape": _ID},
    "get_geometry": {"shape": _ID},
    "delete_shape": {"shape": _ID},
}
_OF_A_PROTOTYPE: Final = {
    name: {"prototype": _ID}
    for name in ("get_prototype", "get_archive", "get_prototype_geometry", "delete_prototype")
}
_OF_ATTRIBUTES: Final = {
    name: {"attributes": _ID} for name in ("get_attributes", "delete_attributes")
}
_OF_A_JOB: Final = {
    name: {"job_id": _ID}
    for name in ("get_job", "follow_job", "cancel_job", "get_result", "get_picture")
}
_OF_AN_UNDRAWN_JOB: Final = {name: of for name, of in _OF_A_JOB.items() if name != "get_picture"}
LINKS: Final[dict[tuple[str, str], dict[str, dict[str, str]]]] = {
    ("upload_shape", "200"): _OF_A_SHAPE,
    ("upload_shape", "201"): _OF_A_SHAPE,
    ("upload_prototype", "200"): _OF_A_PROTOTYPE,
    ("upload_prototype", "201"): _OF_A_PROTOTYPE,
    ("upload_attributes", "200"): _OF_ATTRIBUTES,
    ("upload_attributes", "201"): _OF_ATTRIBUTES,
    ("create_match", "202"): _OF_A_JOB,
    ("create_transfer", "202"): _OF_AN_UNDRAWN_JOB | {"get_arrays": {"job_id": _ID}},
    ("create_registration", "202"): _OF_A_JOB | {"get_arrays": {"job_id": _ID}},
    ("create_consistent_maps", "202"): _OF_AN_UNDRAWN_JOB | {"get_arrays": {"job_id": _ID}},
    ("create_batch", "202"): _OF_AN_UNDRAWN_JOB | {"get_batch": {"job_id": _ID}},
    ("create_prototype", "202"): _OF_AN_UNDRAWN_JOB,
    ("create_dissimilarities", "202"): _OF_A_JOB
    | {name: {"job_id": _ID} for name in ("get_dissimilarities", "get_arrays")},
}
"""Operations and parameters that the answer of an operation with a status links to."""


def illustrate(schema: dict[str, Any]) -> None:
    """Put the examples and the links into an OpenAPI document."""
    components = schema["components"]["schemas"]
    for shown in components.values():
        for example in shown.get("examples", ()):
            _restore_nulls(example, shown, components)
    for calls in schema["paths"].values():
        for call in calls.values():
            _show_parameters(call)
            _show_body(call)
            for status, answer in call["responses"].items():
                _show_answer(call["operationId"], status, answer)


def _restore_nulls(value: Any, schema: dict[str, Any], components: dict[str, Any]) -> None:
    """Put nulls into the example of a schema, from which FastAPI drops them."""
    given = [one for one in schema.get("anyOf", [schema]) if one.get("type") != "null"]
    name = given[0].get("$ref", "").rpartition("/")[2]
    known = components.get(name, given[0])
    if not isinstance(value, dict) or "properties" not in known:
        return
    for field in known.get("required", ()):
        value.setdefault(field, None)
    for field, part in known["properties"].items():
        if field in value:
            _restore_nulls(value[field], part, components)


def _show_parameters(call: dict[str, Any]) -> None:
    for parameter in call.get("parameters", ()):
        if parameter["name"] in EXAMPLES["parameters"]:
            parameter["example"] = EXAMPLES["parameters"][parameter["name"]]


def _show_body(call: dict[str, Any]) -> None:
    example = EXAMPLES["requests"].get(call["operationId"])
    if example is not None:
        for content in call["requestBody"]["content"].values():
            content["example"] = example


def _show_answer(operation: str, status: str, answer: dict[str, Any]) -> None:
    examples = EXAMPLES["answers"].get(operation, {}).get(status, {})
    if examples:
        (content,) = answer["content"].values()
        content["examples"] = {name: {"value": value} for name, value in examples.items()}
    links = LINKS.get((operation, status), {})
    if links:
        answer["links"] = {
            name: {"operationId": name, "parameters": parameters}
            for name, parameters in links.items()
        }
