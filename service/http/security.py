"""Authentication with API keys.

Keys are named by ``ISOMATCH_API_KEYS``, or created in the store while the service runs
(:mod:`service.admin`). Where there are none, everybody may call, but for web pages of other sites
(:mod:`service.http.same_origin`); else everything under ``/v1``
needs one. Probes, metrics and pages need none, as they show nothing that was uploaded.

A key identifies the caller, for the log, for jobs and for the limit of queued jobs, and the
caller's tenant, whose shapes, jobs and prototypes are all that it can see, cancel and delete.
"""

import hashlib
import hmac
import re
import secrets
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import partial
from typing import Annotated, Final, Literal, TypeAlias

import structlog
from pydantic import BeforeValidator
from pydantic_settings import NoDecode
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from broker.contracts import DEFAULT_TENANT, TENANT_NAME
from broker.store import ApiKeys as StoredKeys
from broker.store import StoredKey
from broker.telemetry import logger
from service.http.problem_documents import response
from service.http.problems import StoreAway, Unauthorized
from service.http.same_origin import foreign_request

PROTECTED: Final = "/v1"
"""Paths below this need a key, if there are keys."""

_NOT_KNOWN: Final = "The API keys are not known before the store answers; try again."

log = logger("isomatch.keys")

_HASHED: Final = "sha256:"
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
    tenant
        Whose shapes, jobs and prototypes the key gives access to.
    expires
        From when on it is not accepted; None for never.
    """

    name: str
    digest: bytes = field(repr=False)
    tenant: str = DEFAULT_TENANT
    expires: datetime | None = None

    def valid(self, now: datetime) -> bool:
        """Whether the key is accepted."""
        return self.expires is None or now < self.expires


def read_keys(listing: object) -> object:
    """Read ``NAME:KEY`` or ``NAME:sha256:DIGEST``, separated by commas or white space.

    A name may be preceded by that of the tenant, ``TENANT/NAME``.

    Raises
    ------
    ValueError
        It is not such a list, or repeats a name or a key; the message shows no key.
    """
    if not isinstance(listing, str):
        return listing
    keys = tuple(_read_key(entry) for entry in re.split(r"[,\s]+", listing) if entry)
    for values in ({(key.tenant, key.name) for key in keys}, {key.digest for key in keys}):
        if len(values) < len(keys):
            raise ValueError("a name or a key is repeated; give each once")
    return keys


def _read_key(entry: str) -> ApiKey:
    owner, colon, key = entry.partition(":")
    tenant, slash, name = owner.rpartition("/")
    tenant = tenant if slash else DEFAULT_TENANT
    if not colon or not key or not all(map(TENANT_NAME.fullmatch, (tenant, name))):
        raise ValueError(
            "write NAME:KEY, TENANT/NAME:KEY or [TENANT/]NAME:sha256:DIGEST, separated by commas;"
            " names have letters, digits, dots, dashes and underscores"
        )
    if not key.startswith(_HASHED):
        return ApiKey(name, hashlib.sha256(key.encode()).digest(), tenant)
    digest = key.removeprefix(_HASHED).lower()
    if not _DIGEST.fullmatch(digest):
        raise ValueError(f"the digest of {name} does not have 64 hexadecimal digits")
    return ApiKey(name, bytes.fromhex(digest), tenant)


ApiKeys: TypeAlias = Annotated[tuple[ApiKey, ...], NoDecode, BeforeValidator(read_keys)]
"""The accepted keys; none: everybody may call."""


Auth: TypeAlias = Literal["keys", "none"]
"""Whether keys are needed."""


class KeyRing:
    """The accepted keys: those of the settings, and those in the store as they were last read.

    A key is looked up by its SHA-256, under a hash of this with a secret of this process, so that
    the time that takes shows nothing of the accepted keys, however many there are. Even without
    that it could show only a part of a digest: too little to find the 256 random bits of a created
    key, but enough to tell guesses apart for a key that somebody has thought up.

    Parameters
    ----------
    settings
        Keys of the settings.
    auth
        Whether keys are needed: ``keys`` or ``none``. None: where the settings have some, or one
        was ever created; until the store has told whether, nobody may call.

    Attributes
    ----------
    known
        Whether the keys in the store were read since the process started.
    """

    def __init__(self, settings: tuple[ApiKey, ...], auth: Auth | None) -> None:
        self._settings = settings
        self._auth = auth
        self._secret = secrets.token_bytes(32)
        self._accepted = self._by_place(settings)
        self._stored: tuple[StoredKey, ...] = ()
        self._ever: bool | None = None
        self.known = False

    def refresh(self, stored: StoredKeys) -> None:
        """Read the keys in the store; those known before are accepted until it has answered.

        Raises
        ------
        RedisError
            It does not answer.
        """
        ever, found = stored.ever(), tuple(stored.all())
        if self.known:
            _log_changes(self._stored, found, "key revoked" if ever else "key lost by the store")
        # A store that has lost its data must not let everybody in.
        self._ever, self._stored, self.known = self._ever or ever, found, True
        created = (
            ApiKey(one.name, bytes.fromhex(one.digest), one.tenant, one.expires) for one in found
        )
        # A key of the settings never expires, whatever the store says of the same one.
        self._accepted = self._by_place((*created, *self._settings))

    @property
    def needed(self) -> bool | None:
        """Whether a key is needed; None if that is not known yet."""
        if self._auth is not None:
            return self._auth == "keys"
        return True if self._settings else self._ever

    def find(self, authorization: str) -> ApiKey | None:
        """Return the key in an ``Authorization`` header, or None if it has no accepted one."""
        scheme, _, presented = authorization.partition(" ")
        digest = hashlib.sha256(presented.strip().encode("utf-8", "surrogateescape")).digest()
        key = self._accepted.get(self._place(digest))
        if key is None or scheme.lower() != "bearer" or not key.valid(datetime.now(UTC)):
            return None
        return key if hmac.compare_digest(digest, key.digest) else None

    def admits(self, authorization: str) -> bool:
        """Whether a request with this ``Authorization`` header, or an empty one, may be made."""
        needed = self.needed
        return needed is False or (needed is True and self.find(authorization) is not None)

    def _by_place(self, keys: Iterable[ApiKey]) -> dict[bytes, ApiKey]:
        return {self._place(key.digest): key for key in keys}

    def _place(self, digest: bytes) -> bytes:
        return hashlib.blake2b(digest, key=self._secret).digest()


class Authentication:
    """ASGI middleware that refuses requests without an accepted key, and notes the caller.

    Where no key is needed, it refuses what web pages of other sites send.

    Parameters
    ----------
    app
        The application.
    keys
        The accepted keys.
    hosts
        Names to which it answers without keys, besides those to which it always does.
    """

    def __init__(self, app: ASGIApp, keys: KeyRing, hosts: Collection[str]) -> None:
        self._app = app
        self._keys = keys
        self._hosts = hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on if it is authorised."""
        needed = self._keys.needed
        if scope["type"] != "http" or not protected(scope["path"]):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        authorization = headers.get("authorization", "")
        # For answers that go on after the key is revoked.
        admitted = partial(self._keys.admits, authorization)
        scope["state"] = {**scope.get("state", {}), "admitted": admitted}
        if needed is False:
            foreign = foreign_request(scope["method"], headers, self._hosts)
            allowed = self._app if foreign is None else response(foreign.problem(scope["path"]))
            await allowed(scope, receive, send)
            return
        key = self._keys.find(authorization) if needed else None
        if key is None:
            # Until the store was read, a key that is not found may be one of its keys.
            told = needed and (self._keys.known or not authorization)
            refused = Unauthorized(_reason(authorization)) if told else StoreAway(_NOT_KNOWN)
            later = {} if told else {"Retry-After": "5"}
            answer = response(refused.problem(scope["path"]), {**refused.headers, **later})
            await answer(scope, receive, send)
            return
        known = {"caller": key.name, "tenant": key.tenant}
        scope["state"] |= known
        with structlog.contextvars.bound_contextvars(**known):
            await self._app(scope, receive, send)


def _log_changes(before: tuple[StoredKey, ...], after: tuple[StoredKey, ...], gone: str) -> None:
    """Log the callers whose keys were created or rotated, have expired, or are gone."""
    old, new = {key.digest: key for key in before}, {key.digest: key for key in after}
    now = datetime.now(UTC)
    for digest in new.keys() - old.keys():
        key = new[digest]
        event = "key created" if key.rotated is None else "key rotated"
        log.info(event, tenant=key.tenant, name=key.name)
    for digest in old.keys() - new.keys():
        key = old[digest]
        event = gone if key.valid(now) else "key expired"
        log.info(event, tenant=key.tenant, name=key.name)


def protected(path: str) -> bool:
    """Whether a path needs a key, if there are keys."""
    return path == PROTECTED or path.startswith(PROTECTED + "/")


def _reason(authorization: str) -> str:
    if not authorization:
        return "An API key is needed; send it as `Authorization: Bearer KEY`."
    return (
        "The API key is unknown to this service; send a valid one as `Authorization: Bearer KEY`."
    )
