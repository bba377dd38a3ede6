"""Quotas of tenants: how many shapes they may keep, how many bytes, and how many jobs at a time.

What a tenant has is counted where it is: its listing of shapes, its jobs, and the sizes of its
blobs and of the records of its jobs. A sum that is counted up and down is kept for a minute only,
so that no process that dies, and no record that expires, leaves one that is wrong.
"""

import json
from dataclasses import dataclass, replace

from redis.client import Pipeline

from broker.store import scripts
from broker.store.keys import Keys
from broker.store.replies import text
from broker.store.tenant_data import TenantData


class QuotaExceeded(Exception):
    """A tenant has as much as it may have.

    Parameters
    ----------
    what
        Of what: "shapes" or "bytes".
    used, limit
        What it has, and what it may have.

    Attributes
    ----------
    detail
        What to do about it.
    """

    def __init__(self, what: str, used: int, limit: int) -> None:
        super().__init__(f"{used} of {limit} {what} are used")
        self.detail = (
            f"Your tenant keeps {used} {what}, and may keep {limit}: delete shapes or"
            " results, or wait until they expire."
        )


@dataclass(frozen=True)
class Quota:
    """What a tenant may have; 0 for no limit.

    Parameters
    ----------
    shapes
        Shapes that are kept.
    bytes
        Bytes of what is kept: uploads, meshes, results, and records of listed jobs.
    jobs
        Listed jobs that are queued or running; and, counted apart, validations of uploads.
    """

    shapes: int = 0
    bytes: int = 0
    jobs: int = 0


@dataclass(frozen=True)
class Quotas(TenantData):
    """The quota of a tenant, and what it uses of it."""

    def get(self) -> Quota:
        """Return the tenant's quota."""
        found = self.settings
        usual = Quota(found.tenant_shapes, found.tenant_bytes, found.tenant_jobs)
        return replace(usual, **self.own())

    def own(self) -> dict[str, int]:
        """Return the limits that the tenant has of its own, by name; the others are the usual."""
        own = text(self.client.hget(Keys.QUOTAS, self.keys.tenant))
        limits: dict[str, int] = {} if own is None else json.loads(own)
        return limits

    def set(self, **limits: int) -> None:
        """Give the tenant limits of its own; those that are not given stay as they are."""

        def change(pipe: Pipeline) -> None:
            own = json.dumps({**self.own(), **limits})
            pipe.multi()
            pipe.hset(Keys.QUOTAS, self.keys.tenant, own)

        self.client.transaction(change, Keys.QUOTAS)

    def tenants(self) -> list[str]:
        """Names of all tenants that have limits of their own."""
        return [str(text(name)) for name in self.client.hkeys(Keys.QUOTAS)]

    def unset(self) -> None:
        """Return the tenant to the quota of the settings."""
        self.client.hdel(Keys.QUOTAS, self.keys.tenant)

    def shapes(self, limit: int = 0) -> int:
        """Return the number of shapes that the tenant has.

        Parameters
        ----------
        limit
            Shapes that have expired may be counted up to here, and for a while where they are many.
        """
        prefix = self.keys.shape("")
        return int(scripts.COUNT_LISTED(self.client, [self.keys.shapes], prefix, limit))

    def bytes(self, limit: int = 0) -> int:
        """Return the number of bytes that the tenant has.

        Parameters
        ----------
        limit
            Bytes that have expired may be counted up to here, and for a while where they are many.
        """
        return int(scripts.COUNT_HELD(self.client, [self.keys.held], limit))

    def check(
        self,
        size: int = 0,
        shapes: int = 0,
        pipe: Pipeline | None = None,
        quota: Quota | None = None,
    ) -> None:
        """Refuse to keep more than the tenant may have.

        Parameters
        ----------
        size, shapes
            Bytes and shapes that are to be kept besides those that are.
        pipe
            Of the transaction that stores them, which fails if the tenant gets others meanwhile.
        quota
            The tenant's quota, if it is known already.

        Raises
        ------
        QuotaExceeded
            It would be more.
        """
        quota = quota or self.get()
        if pipe is not None and (quota.shapes or quota.bytes):
            pipe.watch(self.keys.shapes, self.keys.held)
        if quota.shapes and shapes:
            used = self.shapes(quota.shapes - shapes)
            if used + shapes > quota.shapes:
                raise QuotaExceeded("shapes", used, quota.shapes)
        if quota.bytes:
            used = self.bytes(quota.bytes - size)
            if used + size > quota.bytes:
                raise QuotaExceeded("bytes", used, quota.bytes)
