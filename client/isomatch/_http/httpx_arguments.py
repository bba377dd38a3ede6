"""Keyword arguments for httpx2, the same for blocking and asynchronous clients."""

import json
import math
import re
import sys
import time
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any, Final, TypedDict

import httpx2
import numpy as np

from isomatch._http.operation import Call

LOOPBACK: Final = frozenset({"127.0.0.1", "localhost", "::1"})

_LEAST: Final = 0.01
"""Seconds for an answer at a deadline: httpx2 takes no limit of 0."""

_SURROGATES: Final = re.compile("[\ud800-\udfff]")


class ClientArguments(TypedDict):
    """Arguments of ``httpx2.Client`` and ``httpx2.AsyncClient``."""

    base_url: str
    headers: dict[str, str]
    trust_env: bool


CONNECTED: Final = (
    "a connection to a service stays in its process: make a client in each, and send ids of shapes"
    " and jobs, or results"
)
"""Refusal to pickle a client or a job."""

CLOSED: Final = "this client is closed; make a new one"


def client_arguments(base_url: str, api_key: str | None) -> ClientArguments:
    """Return the arguments of a client of one service."""
    headers = {"user-agent": f"isomatch/{version('isomatch')}"}
    if api_key is not None:
        headers["authorization"] = f"Bearer {api_key}"
    # A proxy from the environment cannot reach this machine's own services.
    trust_env = httpx2.URL(base_url).host not in LOOPBACK
    return {"base_url": base_url, "headers": headers, "trust_env": trust_env}


def request_arguments(call: Call, timeout: float | None) -> dict[str, Any]:
    """Return the arguments of ``build_request`` for a call."""
    arguments: dict[str, Any] = {
        "method": call.method,
        "url": call.path,
        "params": {key: value for key, value in call.query.items() if value is not None},
        "timeout": _limit(call, timeout),
        "headers": {**_trace_context(), **call.headers},
    }
    if call.body is not None:
        arguments["content"] = _json(call.body)
        arguments["headers"]["content-type"] = "application/json"
    if call.file is not None:
        arguments["files"] = {"file": (_encodable(call.file.name), call.file.content)}
        arguments["data"] = {field: _encodable(value) for field, value in call.form.items()}
    return arguments


def _limit(call: Call, timeout: float | None) -> float | None:
    """Return the seconds without progress after which a call fails; None for no limit."""
    patience = math.inf if timeout is None else timeout + call.patience
    limit = min(patience, max(call.deadline - time.monotonic(), _LEAST))
    return None if limit == math.inf else limit


def _encodable(name: str) -> str:
    """Return a name with U+FFFD for each surrogate, which UTF-8 cannot encode.

    Python has one for each byte of a file's name that is not UTF-8.
    """
    return _SURROGATES.sub("\N{REPLACEMENT CHARACTER}", name)


def _json(body: Mapping[str, object]) -> bytes:
    """Return a body as JSON; refuse what JSON cannot hold by the name of its field."""
    fields = []
    for name, value in body.items():
        try:
            text = json.dumps(value, allow_nan=False, default=_plain)
        except ValueError as error:
            raise ValueError(f"{name}: numbers must be finite, not nan or infinite") from error
        except TypeError as error:
            raise TypeError(f"{name}: {error}") from error
        fields.append(f"{json.dumps(name)}: {text}")
    return f"{{{', '.join(fields)}}}".encode()


def _plain(value: object) -> object:
    """Return numbers and arrays of numpy as those of Python."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not JSON")


def _trace_context() -> dict[str, str]:
    """Return the headers of the present trace, in a program that uses OpenTelemetry."""
    carrier: dict[str, str] = {}
    if (propagate := sys.modules.get("opentelemetry.propagate")) is not None:
        propagate.inject(carrier)
    return carrier
