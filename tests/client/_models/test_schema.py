"""The client's models are those of the API's schema."""

import json
import re
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from isomatch import (
    Batch,
    ConsistentMaps,
    Dissimilarities,
    LearnedPrototype,
    Match,
    PartialDissimilarities,
    Problem,
    Prototype,
    Registration,
    Shape,
    Structures,
    Transfer,
    Webhook,
    WebhookEvent,
)
from isomatch._models import JobRecord, Page
from pydantic import BaseModel

Schema: TypeAlias = dict[str, Any]

REPOSITORY = Path(__file__).resolve().parents[3]
OPENAPI: Schema = json.loads((REPOSITORY / "openapi" / "openapi.json").read_text())

LEFT_ASIDE = {"links"}
"""What the client does not look at: it knows the paths."""

TAKEN: dict[type[BaseModel], set[str]] = {Registration: {"faces"}}
"""Fields of results whose names an array has: their number is that of its rows."""


def dereferenced(schema: Schema, root: Schema) -> Schema:
    while "$ref" in schema:
        found: Schema = root
        for key in schema["$ref"].removeprefix("#/").split("/"):
            found = found[key]
        schema = found
    return schema


def form(schema: Schema, root: Schema) -> Any:
    """What a schema says of the JSON's form: kinds, fields, which of them are always there."""
    schema = dereferenced(schema, root)
    if "allOf" in schema and len(schema["allOf"]) == 1:
        return form(schema["allOf"][0], root)
    if "anyOf" in schema:
        options = (form(option, root) for option in schema["anyOf"])
        return {"any": sorted(options, key=repr)}
    if "enum" in schema:
        return {"enum": sorted(schema["enum"])}
    if "const" in schema:
        return {"kind": {str: "string", int: "integer"}[type(schema["const"])]}
    kind = schema.get("type")
    if kind == "array" and "prefixItems" in schema:
        return {"fixed": [form(item, root) for item in schema["prefixItems"]]}
    if kind == "array":
        return {"each": form(schema["items"], root)}
    if kind == "object" and "properties" in schema:
        return {
            name: form(part, root)
            for name, part in schema["properties"].items()
            if name not in LEFT_ASIDE and name != "parameters"
        }
    if kind == "object":
        return {"values": form(schema.get("additionalProperties", {}), root)}
    return {"kind": kind}


def takes(ours: Any, served: Any) -> bool:
    """Whether everything of the form `served` is also of the form `ours`."""
    if ours == served:
        return True
    if "any" in served:
        return all(takes(ours, option) for option in served["any"])
    if "any" in ours:
        return any(takes(option, served) for option in ours["any"])
    if "enum" in served:
        return ours == {"kind": "string"} or set(served["enum"]) <= set(ours.get("enum", ()))
    return set(ours) == set(served) and all(
        isinstance(served[key], dict) and takes(ours[key], served[key]) for key in served
    )


def answer(method: str, path: str, status: str = "200") -> Schema:
    operations = {re.sub(r"\{\w+\}", "{}", key): value for key, value in OPENAPI["paths"].items()}
    content = operations[path][method]["responses"][status]["content"]
    schema: Schema = next(iter(content.values()))["schema"]
    return dereferenced(schema, OPENAPI)


def result_of(kind: str) -> Schema:
    """One of the forms a result may have."""
    mapping = answer("get", "/v1/jobs/{}/result")["discriminator"]["mapping"]
    (chosen,) = (one for one in mapping.values() if one.endswith(f"/{kind}"))
    return dereferenced({"$ref": chosen}, OPENAPI)


def body_of(path: str) -> Schema:
    body = OPENAPI["paths"][path]["post"]["requestBody"]
    return dereferenced(body["content"]["application/json"]["schema"], OPENAPI)


ANSWERS: list[tuple[str, type[BaseModel], str, str, str]] = [
    ("uploaded shape", Shape, "post", "/v1/shapes", "201"),
    ("known shape", Shape, "post", "/v1/shapes", "200"),
    ("shape", Shape, "get", "/v1/shapes/{}", "200"),
    ("shapes", Page[Shape], "get", "/v1/shapes", "200"),
    ("structures", Structures, "get", "/v1/structures", "200"),
    ("queued match", JobRecord, "post", "/v1/matches", "202"),
    ("job", JobRecord, "get", "/v1/jobs/{}", "200"),
    ("cancelled job", JobRecord, "delete", "/v1/jobs/{}", "200"),
    ("jobs", Page[JobRecord], "get", "/v1/jobs", "200"),
    ("queued comparison", JobRecord, "post", "/v1/dissimilarities", "202"),
    ("partial matrix", PartialDissimilarities, "get", "/v1/dissimilarities/{}", "200"),
    ("queued learning", JobRecord, "post", "/v1/prototypes", "202"),
    ("prototype", Prototype, "get", "/v1/prototypes/{}", "200"),
    ("prototypes", Page[Prototype], "get", "/v1/prototypes", "200"),
    ("uploaded prototype", Prototype, "post", "/v1/prototype-archives", "201"),
    ("known prototype", Prototype, "post", "/v1/prototype-archives", "200"),
    ("problem", Problem, "get", "/v1/shapes/{}", "404"),
]


def agree(model: type[BaseModel], served: Schema) -> bool:
    ours = model.model_json_schema(mode="serialization")
    taken = TAKEN.get(model, set())
    assert taken <= set(served["properties"])
    properties = {name: one for name, one in served["properties"].items() if name not in taken}
    served = served | {"properties": properties}
    # What the client cannot do without, the service must always send.
    needed = {name for name, field in model.model_fields.items() if field.is_required()}
    return takes(form(ours, ours), form(served, OPENAPI)) and needed <= set(served["required"])


@pytest.mark.parametrize(
    ("model", "method", "path", "status"),
    [pytest.param(*case[1:], id=case[0]) for case in ANSWERS],
)
def test_the_models_are_those_of_the_schema(
    model: type[BaseModel], method: str, path: str, status: str
) -> None:
    assert agree(model, answer(method, path, status))


@pytest.mark.parametrize(
    ("model", "kind"),
    [
        (Match, "MatchResult"),
        (Dissimilarities, "DissimilarityResult"),
        (LearnedPrototype, "PrototypeResult"),
        (Batch, "BatchResult"),
        (Transfer, "TransferResult"),
        (Registration, "RegistrationResult"),
        (ConsistentMaps, "ConsistentMapsResult"),
    ],
)
def test_the_results_are_those_of_the_schema(model: type[BaseModel], kind: str) -> None:
    assert agree(model, result_of(kind))


@pytest.mark.parametrize(
    ("part", "path"),
    [
        ("Correspondence", ("correspondences",)),
        ("Distortion", ("distortion",)),
        ("Alternative", ("alternatives",)),
        ("Level", ("levels",)),
    ],
)
def test_all_parts_of_a_result_are_always_there(part: str, path: tuple[str]) -> None:
    result = result_of("MatchResult")
    schema = dereferenced(result["properties"][path[0]], OPENAPI)
    schema = dereferenced(schema.get("items", schema), OPENAPI)
    ours = Match.model_json_schema(mode="serialization")["$defs"][part]
    assert set(ours["required"]) <= set(schema["required"])


REQUIRED = {
    "/v1/matches": {"source", "target"},
    "/v1/dissimilarities": {"shapes"},
    "/v1/prototypes": {"shapes"},
}


@pytest.mark.parametrize("path", REQUIRED)
def test_required_fields_and_webhooks_are_those_of_the_schema(path: str) -> None:
    body = body_of(path)
    assert set(body["required"]) == REQUIRED[path]
    webhook = dereferenced(body["properties"]["webhook"]["anyOf"][0], OPENAPI)
    assert set(webhook["required"]) == Webhook.__required_keys__
    assert set(webhook["properties"]) == set(Webhook.__annotations__)


def test_what_receivers_are_told_is_that_of_the_schema() -> None:
    request = OPENAPI["webhooks"]["job-ended"]["post"]["requestBody"]
    served = dereferenced(request["content"]["application/json"]["schema"], OPENAPI)
    ours = WebhookEvent.model_json_schema(mode="serialization")
    assert takes(form(ours, ours), form(served, OPENAPI))
