"""What the administration does; each change is logged, without the key."""

from argparse import Namespace
from collections import Counter
from dataclasses import asdict, fields
from datetime import datetime
from typing import Any

from broker.store import Keys, Quota, Store
from broker.telemetry import logger

log = logger("isomatch.admin")


def list_tenants(store: Store, options: Namespace) -> dict[str, Any]:
    """Return the tenants that have keys or a quota, or have had jobs."""
    keys = Counter(key.tenant for key in store.api_keys.all())
    everyone = {*store.tenants(), *keys, *store.quotas.tenants()}
    return {"tenants": [_tenant(store, name, keys[name]) for name in sorted(everyone)]}


def list_keys(store: Store, options: Namespace) -> dict[str, Any]:
    """Return the keys, without what opens the service."""
    return {
        "keys": [
            {
                "tenant": key.tenant,
                "name": key.name,
                "created": _shown(key.created),
                "rotated": None if key.rotated is None else _shown(key.rotated),
                "expires": None if key.expires is None else _shown(key.expires),
            }
            for key in store.api_keys.all()
        ]
    }


def create_key(store: Store, options: Namespace) -> dict[str, Any]:
    """Create a key."""
    key = store.api_keys.create(options.tenant, options.name)
    return _changed(store, "key created", options) | {"key": key}


def rotate_key(store: Store, options: Namespace) -> dict[str, Any]:
    """Replace a key."""
    key = store.api_keys.rotate(options.tenant, options.name, options.grace)
    return _changed(store, "key rotated", options) | {
        "key": key,
        "old_key_expires_in": int(options.grace.total_seconds()),
    }


def revoke_key(store: Store, options: Namespace) -> dict[str, Any]:
    """Refuse a key from now on."""
    store.api_keys.revoke(options.tenant, options.name)
    return _changed(store, "key revoked", options)


def set_quota(store: Store, options: Namespace) -> dict[str, Any]:
    """Give a tenant a quota of its own; what is not given stays as it is.

    Raises
    ------
    ValueError
        Nothing is given.
    """
    quotas = store.of(options.tenant).quotas
    given = {field.name: getattr(options, field.name) for field in fields(Quota)}
    limits = {name: limit for name, limit in given.items() if limit is not None}
    if not limits:
        raise ValueError("give --shapes, --bytes or --jobs")
    quotas.set(**limits)
    store.durability.wait(Keys.QUOTAS)
    log.info("quota set", tenant=options.tenant, **quotas.own())
    return {"tenant": options.tenant, **quotas.own()}


def unset_quota(store: Store, options: Namespace) -> dict[str, Any]:
    """Return a tenant to the quota of the settings."""
    quotas = store.of(options.tenant).quotas
    quotas.unset()
    # The hash of the quotas is gone with the last of them.
    store.durability.wait(Keys.READY)
    log.info("quota unset", tenant=options.tenant)
    return {"tenant": options.tenant, **asdict(quotas.get())}


def _changed(store: Store, event: str, options: Namespace) -> dict[str, Any]:
    store.durability.wait(Keys.API_KEYS_EVER)
    log.info(event, tenant=options.tenant, name=options.name)
    return {"tenant": options.tenant, "name": options.name}


def _tenant(store: Store, name: str, keys: int) -> dict[str, Any]:
    found = store.of(name)
    mine, quota = found.keys, found.quotas.get()
    with store.client.pipeline(transaction=False) as pipe:
        for listing in (mine.prototypes, mine.jobs, mine.admitted):
            pipe.zcard(listing)
        prototypes, jobs, active = pipe.execute()
    return {
        "tenant": name,
        "keys": keys,
        "shapes": _of(found.quotas.shapes(), quota.shapes),
        "bytes": _of(found.quotas.bytes(), quota.bytes),
        "jobs": _of(active, quota.jobs),
        "prototypes": prototypes,
        "remembered_jobs": jobs,
    }


def _of(used: int, limit: int) -> dict[str, int | None]:
    return {"used": used, "quota": limit or None}


def _shown(time: datetime) -> str:
    return time.isoformat(timespec="seconds")
