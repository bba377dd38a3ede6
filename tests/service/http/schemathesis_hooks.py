"""Real ids among the made-up ones, so that more is met than what is not there."""

import json
import os
import re
from typing import Any

import schemathesis

SHAPES, JOBS, PROTOTYPES = (
    json.loads(os.environ.get(f"REAL_{what}", "[]")) for what in ("SHAPES", "JOBS", "PROTOTYPES")
)

_ID = re.compile(r"[0-9a-zA-Z_-]{1,64}")


def real(value: object, ids: list[str]) -> object:
    """A real id for half of the made-up ones, the same for the same.

    What is made up to be refused, because no id is of this form, stays as it is.
    """
    if not _ID.fullmatch(str(value)):
        return value
    number = sum(str(value).encode())
    return ids[number // 2 % len(ids)] if ids and number % 2 else value


@schemathesis.hook
def map_path_parameters(context: Any, path_parameters: Any) -> Any:
    # What is deleted is not there for those who come after.
    for name, ids in (("shape", SHAPES), ("job_id", JOBS), ("prototype", PROTOTYPES)):
        if name in (path_parameters or {}) and context.operation.method != "delete":
            path_parameters[name] = real(path_parameters[name], ids)
    return path_parameters


@schemathesis.hook
def map_body(context: Any, body: Any) -> Any:
    if isinstance(body, dict):
        for name in ("source", "target"):
            if isinstance(body.get(name), str):
                body[name] = real(body[name], SHAPES)
        # Of the sources that are real some are prototypes.
        if body.get("source") in SHAPES and len(str(body.get("target"))) % 3 == 0:
            body["source"] = PROTOTYPES[0]
        if isinstance(body.get("shapes"), list):
            body["shapes"] = [real(value, SHAPES) for value in body["shapes"]]
    return body
