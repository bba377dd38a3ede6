"""Authentication with API keys.

Without ``ISOMATCH_API_KEYS`` everybody may call. With it, everything under ``/v1`` needs a key;
probes, metrics and pages need none, as they show nothing that was uploaded. A key identifies the
caller, for the log, for jobs and for the limit of queued jobs; shapes and jobs are shared by all
keys of a service.
"""

import hashlib
import hmac
import re
from dataclasses import dataclass, field
from typing import Annotated, Final, TypeAlias

import structlog
from pydantic import BeforeValidator
from pydantic_settings import NoDecode
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from service.http.problem_documents import response
from service.http.problems import Unauthorized

PROTECTED: Final = "/v1"
"""Paths below this need a key, if there are keys."""

_HASHED: Final = "sha256:"
_NAME: Final = re.compile(r"[A-Za-z0-9._-]{1,64}")
_DIGEST: Final = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class ApiKey:
    """An accepted key.

    Parameters
    ----------
    name
        Name of the caller, as jobs and logs show it.
    digest
        SHA-256 of the key, which is not stored itself.
    """

    name: str
    digest: bytes = field(repr=False)


def read_keys(listing: object) -> object:
    """Read ``NAME:KEY`` or ``NAME:sha256:DIGEST``, separated by commas or white space.

    Raises
    ------
    ValueError
        It is not such a list, or repeats a name or a key; the message shows no key.
    """
    if not isinstance(listing, str):
        return listing
    keys = tuple(_read_key(entry) for entry in re.split(r"[,\s]+", listing) if entry)
    for values in ([key.name for key in keys], [key.digest for key in keys]):
        if len(set(values)) < len(values):
            raise ValueError("a name or a key is repeated; give each once")
    return keys


def _read_key(entry: str) -> ApiKey:
    name, colon, key = entry.partition(":")
    if not colon or not key or not _NAME.fullmatch(name):
        raise ValueError(
            "write NAME:KEY or NAME:sha256:DIGEST, separated by commas; names have letters,"
            " digits, dots, dashes and underscores"
        )
    if not key.startswith(_HASHED):
        return ApiKey(name, hashlib.sha256(key.encode()).digest())
    digest = key.removeprefix(_HASHED).lower()
    if not _DIGEST.fullmatch(digest):
        raise ValueError(f"the digest of {name} does not have 64 hexadecimal digits")
    return ApiKey(name, bytes.fromhex(digest))


ApiKeys: TypeAlias = Annotated[tuple[ApiKey, ...], NoDecode, BeforeValidator(read_keys)]
"""The accepted keys; none: everybody may call."""


def caller_of(authorization: str, keys: tuple[ApiKey, ...]) -> str | None:
    """Return the name of the key in an ``Authorization`` header, or None if it has no accepted one.

    Parameters
    ----------
    authorization
        The header.
    keys
        The accepted keys.
    """
    scheme, _, presented = authorization.partition(" ")
    digest = hashlib.sha256(presented.strip().encode("utf-8", "surrogateescape")).digest()
    found = None
    for key in keys:
        # All keys are compared, in constant time, so that the time reveals nothing about them.
        if hmac.compare_digest(digest, key.digest):
            found = key.name
    return found if scheme.lower() == "bearer" else None


class Authentication:
    """ASGI middleware that refuses requests without an accepted key, and notes the caller.

    Parameters
    ----------
    app
        The application.
    keys
        The accepted keys; none: everybody may call.
    """

    def __init__(self, app: ASGIApp, keys: tuple[ApiKey, ...]) -> None:
        self._app = app
        self._keys = keys

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on if it is authorised."""
        if scope["type"] != "http" or not self._keys or not _protected(scope["path"]):
            await self._app(scope, receive, send)
            return
        authorization = Headers(scope=scope).get("authorization", "")
        caller = caller_of(authorization, self._keys)
        if caller is None:
            refused = Unauthorized(_reason(authorization))
            answer = response(refused.problem(scope["path"]), refused.headers)
            await answer(scope, receive, send)
            return
        scope["state"] = {**scope.get("state", {}), "caller": caller}
        with structlog.contextvars.bound_contextvars(caller=caller):
            await self._app(scope, receive, send)


def _protected(path: str) -> bool:
    return path == PROTECTED or path.startswith(PROTECTED + "/")


def _reason(authorization: str) -> str:
    if not authorization:
        return "An API key is needed; send it as `Authorization: Bearer KEY`."
    return (
        "The API key is unknown to this service; send a valid one as `Authorization: Bearer KEY`."
    )
