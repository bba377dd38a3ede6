"""API keys that are created, rotated and revoked while the service runs.

A key has 256 random bits, so that its SHA-256 is enough to recognise it, and too little to find it:
a slow hash protects passwords that can be guessed. The key itself is not stored.
"""

import hashlib
import json
import secrets
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, fields, replace
from datetime import UTC, datetime, timedelta
from typing import Final, TypeVar

from redis import Redis
from redis.client import Pipeline

from broker.store.keys import Keys
from broker.store.replies import text
from broker.store.transactions import transact

KEY_PREFIX: Final = "isomatch_"
"""What a created key begins with, so that it is recognised where it does not belong."""

ResultT = TypeVar("ResultT")


class NameTaken(ValueError):
    """A tenant has a key of this name already."""


class NoSuchKey(LookupError):
    """A tenant has no key of this name."""


@dataclass(frozen=True)
class StoredKey:
    """A key as it is stored.

    Parameters
    ----------
    tenant, name
        Whose key it is.
    digest
        SHA-256 of the key, hexadecimal.
    created
        When the first key of this name was created.
    expires
        From when on it is not accepted; None for never.
    rotated
        When this key replaced an earlier one; None if it did not.
    """

    tenant: str
    name: str
    digest: str
    created: datetime
    expires: datetime | None = None
    rotated: datetime | None = None

    def valid(self, now: datetime) -> bool:
        """Whether the key is accepted."""
        return self.expires is None or now < self.expires


@dataclass(frozen=True)
class ApiKeys:
    """The stored keys of all tenants.

    Parameters
    ----------
    client
        Connection to Redis.
    """

    client: Redis

    def all(self) -> list[StoredKey]:
        """Return all keys that have not expired, by tenant and name, the newest of a name last."""
        now = datetime.now(UTC)
        return [key for key in _read(self.client.hgetall(Keys.API_KEYS).values()) if key.valid(now)]

    def ever(self) -> bool:
        """Whether a key was ever created: from then on, nobody may call without one."""
        return bool(self.client.exists(Keys.API_KEYS_EVER))

    def create(self, tenant: str, name: str) -> str:
        """Create a key, and return it: it cannot be shown again.

        Raises
        ------
        NameTaken
            The tenant has a key of this name.
        """

        def change(known: list[StoredKey], pipe: Pipeline) -> str:
            if any((one.tenant, one.name) == (tenant, name) for one in known):
                raise NameTaken(f"{tenant} has a key {name}; rotate or revoke it")
            return _add(tenant, name, pipe)

        return self._change(change)

    def rotate(self, tenant: str, name: str, grace: timedelta) -> str:
        """Replace a key by a new one, and return that; the old one is accepted a while longer.

        Raises
        ------
        NoSuchKey
            The tenant has no key of this name.
        """

        def change(known: list[StoredKey], pipe: Pipeline) -> str:
            end = datetime.now(UTC) + grace
            earlier = _named(known, tenant, name)
            for one in earlier:
                # A key that was rotated before does not live longer by it.
                _put(replace(one, expires=min(end, one.expires or end)), pipe)
            return _add(tenant, name, pipe, created=earlier[0].created)

        return self._change(change)

    def revoke(self, tenant: str, name: str) -> None:
        """Delete a key, and those that it replaced.

        Raises
        ------
        NoSuchKey
            The tenant has no key of this name.
        """

        def change(known: list[StoredKey], pipe: Pipeline) -> None:
            pipe.hdel(Keys.API_KEYS, *(one.digest for one in _named(known, tenant, name)))

        self._change(change)

    def _change(self, change: Callable[[list[StoredKey], Pipeline], ResultT]) -> ResultT:
        """Change the keys in one transaction, and delete those that have expired."""

        def attempt(pipe: Pipeline) -> ResultT:
            pipe.watch(Keys.API_KEYS)
            stored = _read(self.client.hgetall(Keys.API_KEYS).values())
            now = datetime.now(UTC)
            pipe.multi()
            for one in stored:
                if not one.valid(now):
                    pipe.hdel(Keys.API_KEYS, one.digest)
            answer = change([one for one in stored if one.valid(now)], pipe)
            pipe.set(Keys.API_KEYS_EVER, b"1")
            return answer

        return transact(self.client, attempt)


def _named(known: list[StoredKey], tenant: str, name: str) -> list[StoredKey]:
    found = [one for one in known if (one.tenant, one.name) == (tenant, name)]
    if not found:
        raise NoSuchKey(f"{tenant} has no key {name}")
    return found


def _add(tenant: str, name: str, pipe: Pipeline, created: datetime | None = None) -> str:
    key = KEY_PREFIX + secrets.token_urlsafe(32)
    digest = hashlib.sha256(key.encode()).hexdigest()
    now = datetime.now(UTC)
    rotated = None if created is None else now
    _put(StoredKey(tenant, name, digest, created or now, rotated=rotated), pipe)
    return key


def _put(key: StoredKey, pipe: Pipeline) -> None:
    given = {name: value for name, value in asdict(key).items() if value is not None}
    pipe.hset(Keys.API_KEYS, key.digest, json.dumps(given, default=datetime.isoformat))


def _read(stored: Iterable[bytes | str]) -> list[StoredKey]:
    known = {field.name for field in fields(StoredKey)}
    found = []
    for value in stored:
        # A newer version may store more, which must not keep this one from reading its keys.
        given = {name: one for name, one in json.loads(text(value)).items() if name in known}
        times = {
            name: datetime.fromisoformat(given[name])
            for name in ("created", "expires", "rotated")
            if name in given
        }
        found.append(StoredKey(**(given | times)))
    return sorted(found, key=lambda key: (key.tenant, key.name, key.rotated or key.created))
