"""The OpenAPI document: FastAPI's, with problem documents, authentication, examples and links."""

import json
from typing import Any, Final

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from broker.contracts import Problem
from service.http.openapi.examples import illustrate
from service.http.openapi.headers import declare_headers
from service.http.problem_documents import responses
from service.http.problems import ApiProblem, CrossSiteRequest, MisdirectedRequest, Unauthorized
from service.http.same_origin import SAFE_METHODS
from service.http.security import PROTECTED

DESCRIPTION = """\
Correspondences of minimum distortion between non-rigid shapes, each with a certificate and its
confidence.

1. `POST /v1/shapes`: upload two meshes.
2. `POST /v1/matches`: request their correspondence.
3. `GET /v1/jobs/{id}?wait=60`: wait for it.
4. `GET /v1/jobs/{id}/result` and `/v1/jobs/{id}/result.png`: fetch it.

One source is matched with many targets by `POST /v1/batches`, a collection is compared by
`POST /v1/dissimilarities`, a template is registered to specimens by `POST /v1/registrations`,
maps of a collection are made consistent by `POST /v1/consistent-maps`, and a prototype of a class
is learned by `POST /v1/prototypes`: their jobs are waited for in the same way. A prototype's id can
be the `source` of a match. Attributes and landmarks are transferred along a match by
`POST /v1/transfers`.

Every error is answered with a problem document, `application/problem+json` (RFC 9457).
"""


TAGS: Final[dict[str, str]] = {
    "shapes": "Uploaded meshes and point clouds.",
    "structures": "Metrics and descriptors that can be chosen.",
    "matches": "Correspondences of two shapes, or of a prototype and a shape.",
    "batches": "One source matched with many targets.",
    "transfers": "Attributes, landmarks and textures carried along a match, and attribute files.",
    "dissimilarities": "Collections of shapes, all compared with all.",
    "registrations": "A template registered to specimens.",
    "consistent maps": "Maps between all shapes of a collection that agree with one another.",
    "prototypes": "Prototypes of classes of shapes.",
    "jobs": "States, results and files of jobs.",
    "health": "Probes.",
}
"""Descriptions of the tags."""


def document(app: FastAPI) -> dict[str, Any]:
    """Return the OpenAPI document of the application."""
    schema = get_openapi(
        title=app.title,
        version=app.version,
        summary="Non-rigid shape matching",
        description=DESCRIPTION,
        routes=app.routes,
        webhooks=app.webhooks.routes,
        tags=[{"name": name, "description": text} for name, text in TAGS.items()],
        license_info={"name": "MIT", "identifier": "MIT"},
    )
    components = schema.setdefault("components", {}).setdefault("schemas", {})
    # All errors are problem documents; FastAPI's own schemas describe answers never sent. The
    # unknown structures only make errors short.
    for unused in ("HTTPValidationError", "ValidationError", "UnknownMetric", "UnknownDescriptor"):
        components.pop(unused, None)
    problem = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
    components |= problem.pop("$defs", {})
    components["Problem"] = problem
    for calls in schema.get("webhooks", {}).values():
        for call in calls.values():
            call["responses"].pop("422", None)
    _mark_files(components)
    _close_forms(components)
    _require_keys(schema)
    declare_headers(schema)
    illustrate(schema)
    _whole_bounds(schema)
    schema["components"]["schemas"] = dict(sorted(components.items()))
    return schema


def _require_keys(schema: dict[str, Any]) -> None:
    schema["components"]["securitySchemes"] = {
        "apiKey": {
            "type": "http",
            "scheme": "bearer",
            "description": "An API key, if the service has any.",
        }
    }
    for path, calls in schema["paths"].items():
        if path.startswith(PROTECTED + "/"):
            for method, call in calls.items():
                call["security"] = [{"apiKey": []}, {}]
                refusals: list[type[ApiProblem]] = [Unauthorized, MisdirectedRequest]
                if method.upper() not in SAFE_METHODS:
                    refusals.append(CrossSiteRequest)
                documented = responses(*refusals)
                for kind in refusals:
                    call["responses"][str(kind.type.status)] = documented[kind.type.status]


def _mark_files(node: Any) -> None:
    # Client generators recognise files by OpenAPI 3.0's `format`; they take 3.1's mark for text.
    if isinstance(node, dict):
        if node.get("contentMediaType") == "application/octet-stream":
            node["format"] = "binary"
        for child in node.values():
            _mark_files(child)
    elif isinstance(node, list):
        for child in node:
            _mark_files(child)


def _whole_bounds(node: Any) -> None:
    # FastAPI writes the bounds of integers as 256.0.
    if isinstance(node, dict):
        if node.get("type") == "integer":
            for bound in ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"):
                if bound in node:
                    node[bound] = int(node[bound])
        for child in node.values():
            _whole_bounds(child)
    elif isinstance(node, list):
        for child in node:
            _whole_bounds(child)


def _close_forms(components: dict[str, Any]) -> None:
    # The service refuses other parts, which FastAPI's schemas of forms permit.
    for name, schema in components.items():
        if name.startswith("Body_"):
            schema["additionalProperties"] = False


def text(app: FastAPI) -> str:
    """Return the OpenAPI document as the text of a file."""
    return json.dumps(app.openapi(), indent=2, ensure_ascii=False) + "\n"
