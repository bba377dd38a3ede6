"""``python -m service.admin``: API keys and quotas of tenants, of a service that may be running."""

import argparse
import json
import sys
from datetime import timedelta
from typing import Any

from pydantic import ValidationError
from redis.exceptions import RedisError

from broker.contracts import TENANT_NAME
from broker.environment import setting_errors
from broker.store import NameTaken, NoSuchKey, Store
from broker.telemetry import configure_logging
from service.admin.commands import (
    create_key,
    list_keys,
    list_tenants,
    revoke_key,
    rotate_key,
    set_quota,
    unset_quota,
)
from service.settings import Settings
from service.standalone.embedded import address_in


def main() -> int:
    """Run one command, and return its exit code."""
    options = _parser().parse_args()
    configure_logging("INFO", process="admin")
    try:
        store = _open()
    except ValidationError as error:
        for line in setting_errors(error):
            print(f"admin: {line}", file=sys.stderr)
        return 2
    except ValueError as error:
        print(f"admin: {error}", file=sys.stderr)
        return 2
    try:
        done: dict[str, Any] = options.run(store, options)
    except (NameTaken, NoSuchKey) as error:
        print(f"admin: {error.args[0]}", file=sys.stderr)
        return 1
    except ValueError as error:
        print(f"admin: {error}", file=sys.stderr)
        return 2
    except RedisError as error:
        print(f"admin: the store cannot be used: {error}", file=sys.stderr)
        return 1
    finally:
        store.close()
    print(json.dumps(done, indent=2) if options.json else _lines(done))
    return 0


def _open() -> Store:
    settings = Settings()
    if settings.redis_url is None:
        address = address_in(settings.data_dir / "redis")
        if address is None:
            raise ValueError(
                "no store: set ISOMATCH_REDIS_URL and ISOMATCH_BLOB_URL, or call this in the folder"
                f" of a running service (none runs in {settings.data_dir.resolve()})"
            )
        blobs = settings.blob_url or (settings.data_dir.resolve() / "blobs").as_uri()
        settings = settings.model_copy(update={"redis_url": address, "blob_url": blobs})
    return Store.open(settings, retry_seconds=1.0)


def _parser() -> argparse.ArgumentParser:
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--json", action="store_true", help="print JSON")
    parser = argparse.ArgumentParser(
        prog="python -m service.admin",
        description="API keys and tenants. The store is that of ISOMATCH_REDIS_URL, or of the"
        " service that runs with its own Redis in ISOMATCH_DATA_DIR.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    tenants = commands.add_parser(
        "tenants", parents=[common], help="list tenants, and what they have"
    )
    tenants.set_defaults(run=list_tenants)
    keys = commands.add_parser("keys", help="list, create, rotate and revoke API keys")
    actions = keys.add_subparsers(required=True, metavar="ACTION")
    listing = actions.add_parser("list", parents=[common], help="list keys; no key itself is shown")
    listing.set_defaults(run=list_keys)
    for name, run, about in (
        ("create", create_key, "create a key, and show it this once"),
        ("rotate", rotate_key, "replace a key by a new one, which is shown this once"),
        ("revoke", revoke_key, "refuse a key from now on"),
    ):
        action = actions.add_parser(name, parents=[common], help=about)
        action.add_argument("--tenant", required=True, type=_name, help="whose key it is")
        action.add_argument("--name", required=True, type=_name, help="who uses it")
        action.set_defaults(run=run)
        if name == "rotate":
            action.add_argument(
                "--grace",
                type=_seconds,
                default=timedelta(hours=1),
                metavar="SECONDS",
                help="how long the old key is still accepted (3600)",
            )
    quota = commands.add_parser("quota", help="set what tenants may have")
    changes = quota.add_subparsers(required=True, metavar="ACTION")
    for name, run, about in (
        ("set", set_quota, "give a tenant a quota of its own; 0 for no limit"),
        ("unset", unset_quota, "return a tenant to the quota of the settings"),
    ):
        change = changes.add_parser(name, parents=[common], help=about)
        change.add_argument("tenant", type=_name, metavar="TENANT")
        change.set_defaults(run=run)
        if name == "set":
            change.add_argument("--shapes", type=_count, metavar="N", help="shapes that are kept")
            change.add_argument("--bytes", type=_count, metavar="N", help="bytes that are kept")
            change.add_argument("--jobs", type=_count, metavar="N", help="jobs queued or running")
    return parser


def _name(value: str) -> str:
    if not TENANT_NAME.fullmatch(value):
        raise argparse.ArgumentTypeError(
            f"{value!r} is no name: up to 64 letters, digits, dots, dashes and underscores"
        )
    return value


def _count(value: str) -> int:
    if not value.isdecimal() or len(value) > 18:
        raise argparse.ArgumentTypeError(f"{value!r} is no number, 0 or more")
    return int(value)


def _seconds(value: str) -> timedelta:
    if not value.isdecimal() or int(value) > 10 * 365 * 86400:
        raise argparse.ArgumentTypeError(f"{value!r} is no number of seconds, 0 to ten years")
    return timedelta(seconds=int(value))


def _lines(done: dict[str, Any]) -> str:
    """Return a result for people: a table of each list, and a line for each other value."""
    lines = []
    for name, value in done.items():
        if isinstance(value, list):
            lines += _table(value) or [f"no {name}"]
        else:
            lines.append(f"{name}: {value}")
    return "\n".join(lines)


def _table(rows: list[dict[str, Any]]) -> list[str]:
    if not rows:
        return []
    cells = [[*rows[0]], *([_cell(value) for value in row.values()] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in cells
    ]


def _cell(value: object) -> str:
    if isinstance(value, dict):
        return f"{value['used']} of {value['quota'] or 'any'}"
    return "-" if value is None else str(value)


if __name__ == "__main__":
    sys.exit(main())
