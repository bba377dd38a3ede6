"""Keys that are created, rotated and revoked while services run, by the command that does it."""

import io
import json
import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import httpx2
import pytest
import structlog
from pydantic import ValidationError
from redis.exceptions import ConnectionError as RedisConnectionError

from broker.contracts import MatchParameters, MatchPayload
from broker.queue import JobQueue, QueueSettings
from broker.store import ApiKeys, Keys, NameTaken, NoSuchKey, Store, connect
from service import app
from service.admin.__main__ import main
from service.http import KeyRing
from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.blobs import blob_url
from tests.service.conftest import Api, Json, empty_database, problem, running_api
from tests.waiting import until

ROOT = Path(__file__).resolve().parents[2]
PARAMETERS = MatchParameters()
NOTICED = 5.0
"""Seconds within which running services follow a change."""


@pytest.fixture
def stores(server: EmbeddedServer, tmp_path: Path) -> dict[str, Any]:
    return {"redis_url": empty_database(server), "blob_url": blob_url(tmp_path)}


@pytest.fixture
def store(stores: dict[str, Any]) -> Iterator[Store]:
    opened = Store.open(Settings(**stores), retry_seconds=1)
    yield opened
    opened.close()


@contextmanager
def two_services(stores: dict[str, Any]) -> Iterator[list[Api]]:
    with ExitStack() as stack:
        yield [stack.enter_context(running_api(Settings(**stores))) for _ in range(2)]


@dataclass(frozen=True)
class Said:
    """What a command prints."""

    stdout: str
    stderr: str


def admin(stores: dict[str, Any], *words: str, code: int = 0) -> Said:
    """Run a command, in this process."""
    out, err = io.StringIO(), io.StringIO()
    named = {f"ISOMATCH_{name.upper()}": value for name, value in stores.items()}
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr(sys, "argv", ["service.admin", *words])
        for name, value in named.items():
            patch.setenv(name, value)
        try:
            returned = main()
        except SystemExit as left:
            returned = int(str(left.code))
    assert returned == code, err.getvalue()
    return Said(out.getvalue(), err.getvalue())


def document(stores: dict[str, Any], *words: str) -> Json:
    found: Json = json.loads(admin(stores, *words, "--json").stdout)
    return found


def status(api: Api, key: str | None) -> int:
    headers = {} if key is None else {"Authorization": f"Bearer {key}"}
    return httpx2.get(f"{api.url}/v1/shapes", headers=headers).status_code


def noticed(services: list[Api], expected: dict[str | None, int]) -> None:
    """Wait until every service answers so."""
    until(
        lambda: all(status(api, key) == code for api in services for key, code in expected.items()),
        NOTICED,
        pause=0.1,
    )


def test_keys_change_while_two_services_run(
    stores: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert 2 * app.KEYS_INTERVAL < NOTICED
    monkeypatch.setattr(app, "KEYS_INTERVAL", 0.2)
    with two_services(stores) as services:
        noticed(services, {None: 200})
        first = document(stores, "keys", "create", "--tenant", "acme", "--name", "alice")["key"]
        noticed(services, {None: 401, first: 200, first[:-1]: 401})
        rotated = document(
            stores, "keys", "rotate", "--tenant", "acme", "--name", "alice", "--grace", "3600"
        )
        second = rotated["key"]
        noticed(services, {first: 200, second: 200})
        listed = document(stores, "keys", "list")["keys"]
        assert [(key["tenant"], key["name"]) for key in listed] == [("acme", "alice")] * 2
        assert [key["expires"] is None for key in listed] == [False, True]
        assert [key["rotated"] is None for key in listed] == [True, False]
        assert listed[0]["created"] == listed[1]["created"]
        third = document(
            stores, "keys", "rotate", "--tenant", "acme", "--name", "alice", "--grace", "0"
        )["key"]
        noticed(services, {first: 401, second: 401, third: 200})
        queue = JobQueue(services[0].store.of("acme"), QueueSettings())
        job = queue.submit(MatchPayload(source="a", target="b", parameters=PARAMETERS))
        events, headers = f"/v1/jobs/{job.id}/events", {"Authorization": f"Bearer {third}"}
        with httpx2.stream("GET", services[0].url + events, headers=headers, timeout=60) as stream:
            lines = stream.iter_lines()
            assert next(lines) == "event: job"
            document(stores, "keys", "revoke", "--tenant", "acme", "--name", "alice")
            revoked = time.monotonic()
            assert all(not line.startswith("event") for line in lines)
            assert time.monotonic() - revoked < NOTICED
        # The last key that is revoked does not open the service again.
        noticed(services, {third: 401, None: 401})
        assert document(stores, "keys", "list") == {"keys": []}
    with two_services(stores) as services:
        assert [status(api, None) for api in services] == [401, 401]


def test_the_command_itself(stores: dict[str, Any]) -> None:
    named = {f"ISOMATCH_{name.upper()}": value for name, value in stores.items()}
    words = ["keys", "create", "--tenant", "acme", "--name", "alice", "--json"]
    done = subprocess.run(
        [sys.executable, "-m", "service.admin", *words],
        cwd=ROOT,
        env={**os.environ, **named},
        capture_output=True,
        text=True,
        check=True,
    )
    key = json.loads(done.stdout)["key"]
    assert key.startswith("isomatch_")
    assert key not in done.stderr
    assert json.loads(done.stderr)["event"] == "key created"


def test_what_people_are_shown(stores: dict[str, Any]) -> None:
    made = admin(stores, "keys", "create", "--tenant", "acme", "--name", "bob").stdout
    key = made.splitlines()[-1].removeprefix("key: ")
    assert made.splitlines()[:-1] == ["tenant: acme", "name: bob"]
    listed = admin(stores, "keys", "list").stdout
    assert listed.split()[:5] == ["tenant", "name", "created", "rotated", "expires"]
    assert key not in listed
    tenants = admin(stores, "tenants").stdout.splitlines()
    assert [line.split()[:2] for line in tenants[1:]] == [["acme", "1"], ["default", "0"]]


def test_quotas_are_set_and_unset(stores: dict[str, Any]) -> None:
    found = document(stores, "quota", "set", "acme", "--shapes", "5", "--jobs", "2")
    assert found == {"tenant": "acme", "shapes": 5, "jobs": 2}
    # What is not named stays as it is.
    found = document(stores, "quota", "set", "acme", "--jobs", "0")
    assert found == {"tenant": "acme", "shapes": 5, "jobs": 0}
    (tenant, _) = document(stores, "tenants")["tenants"]
    assert tenant["shapes"] == {"used": 0, "quota": 5}
    assert tenant["jobs"] == {"used": 0, "quota": None}
    shown = admin(stores, "tenants").stdout.splitlines()[1]
    assert "0 of 5" in shown
    assert "0 of any" in shown
    defaults = stores | {"tenant_shapes": "7"}
    (tenant, _) = document(defaults | {"tenant_bytes": "9"}, "tenants")["tenants"]
    assert [tenant[what]["quota"] for what in ("shapes", "bytes", "jobs")] == [5, 9, None]
    assert document(defaults, "quota", "unset", "acme")["shapes"] == 7


@pytest.mark.parametrize("words", [("set", "acme", "--jobs", "2"), ("unset", "acme")])
def test_a_quota_is_changed_on_the_disk(tmp_path: Path, words: tuple[str, ...]) -> None:
    own = EmbeddedServer(tmp_path)
    own.start()
    stores = {"redis_url": own.url, "blob_url": blob_url(tmp_path)}
    try:
        with connect(own.url, retry_seconds=1) as client:
            # The file is flushed to the disk whenever the system likes.
            client.config_set("appendfsync", "no")
        assert "has not written its file" in admin(stores, "quota", *words, code=1).stderr
    finally:
        own.stop()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("keys", "revoke", "--tenant", "a", "--name", "b"), 1, "a has no key b"),
        (("keys", "rotate", "--tenant", "a", "--name", "b"), 1, "a has no key b"),
        (("keys", "create", "--tenant", "a/b", "--name", "b"), 2, "is no name"),
        (("keys", "rotate", "--tenant", "a", "--name", "b", "--grace", "-1"), 2, "--grace"),
        (("keys",), 2, "ACTION"),
        (("quota", "set", "acme", "--shapes", "-1"), 2, "--shapes"),
        (("quota", "set", "acme"), 2, "give --shapes"),
    ],
)
def test_what_cannot_be_done_is_said(
    stores: dict[str, Any], words: tuple[str, ...], code: int, said: str
) -> None:
    refused = admin(stores, *words, code=code)
    assert said in refused.stderr
    assert "Traceback" not in refused.stderr


def test_a_store_that_is_not_there_is_said(tmp_path: Path) -> None:
    alone = {"data_dir": str(tmp_path)}
    assert "no store" in admin(alone, "keys", "list", code=2).stderr
    away = {"redis_url": f"unix://{tmp_path}/none.sock", "blob_url": blob_url(tmp_path)}
    assert "store cannot be used" in admin(away, "keys", "list", code=1).stderr


@pytest.mark.parametrize("name", ["data", "d" * 120])
def test_the_store_of_a_service_of_its_own_is_found(tmp_path: Path, name: str) -> None:
    """Also where the path of its socket would be too long."""
    folder = {"data_dir": str(tmp_path / name)}
    own = EmbeddedServer(tmp_path / name / "redis")
    own.start()
    try:
        made = document(folder, "keys", "create", "--tenant", "a", "--name", "b")
        assert made["tenant"] == "a"
    finally:
        own.stop()
    assert "no store" in admin(folder, "keys", "list", code=2).stderr


def test_keys_are_stored_hashed(store: Store) -> None:
    key = store.api_keys.create("acme", "alice")
    held = [value for name in store.client.keys("*") for value in _everything(store, name)]
    assert not any(key.encode() in value for value in held)
    assert not any(key.removeprefix("isomatch_").encode() in value for value in held)


def _everything(store: Store, name: bytes | str) -> list[Any]:
    if store.client.type(name) == b"hash":
        return [part for pair in store.client.hgetall(name).items() for part in pair]
    return [store.client.get(name)]


def test_names_are_taken_once_however_many_ask(store: Store) -> None:
    start = threading.Barrier(8)

    def create() -> bool:
        start.wait()
        try:
            store.api_keys.create("acme", "alice")
        except NameTaken:
            return False
        return True

    with ThreadPoolExecutor(8) as threads:
        made = [future.result() for future in [threads.submit(create) for _ in range(8)]]
    assert sum(made) == 1
    store.api_keys.create("other", "alice")


def test_a_replaced_key_ends_when_it_was_to_end(store: Store) -> None:
    keys = store.api_keys
    keys.create("acme", "alice")
    keys.rotate("acme", "alice", timedelta(seconds=60))
    keys.rotate("acme", "alice", timedelta(hours=5))
    ends = [key.expires for key in keys.all()]
    assert ends[0] is not None
    assert ends[0] < datetime.now(UTC) + timedelta(seconds=61)
    assert ends[2] is None
    assert [key.valid(datetime.now(UTC) + timedelta(seconds=61)) for key in keys.all()] == [
        False,
        True,
        True,
    ]
    keys.rotate("acme", "alice", timedelta(0))
    assert len(keys.all()) == 1
    keys.revoke("acme", "alice")
    with pytest.raises(NoSuchKey):
        keys.revoke("acme", "alice")
    # Those that expired are not kept.
    assert store.client.hlen(Keys.API_KEYS) == 0


class Away(ApiKeys):
    """Keys of a store that does not answer."""

    def ever(self) -> bool:
        raise RedisConnectionError


def test_nobody_may_call_before_it_is_known_whether_keys_are_needed(
    server: EmbeddedServer, stores: dict[str, Any], tmp_path: Path
) -> None:
    away = stores | {"redis_url": f"unix://{tmp_path}/none.sock", "redis_patience": "0"}
    with running_api(Settings(**away)) as api:
        answer = httpx2.get(f"{api.url}/v1/shapes")
        problem(answer, 503, "store-away")
        assert "API key" in answer.text
        assert httpx2.get(f"{api.url}/health/live").status_code == 200


def test_keys_once_known_are_accepted_while_the_store_is_away(store: Store) -> None:
    ring = KeyRing((), None)
    assert ring.needed is None
    ring.refresh(store.api_keys)
    assert ring.needed is False
    key = store.api_keys.create("acme", "alice")
    ring.refresh(store.api_keys)
    with pytest.raises(RedisConnectionError):
        ring.refresh(Away(store.client))
    assert ring.needed
    found = ring.find(f"Bearer {key}")
    assert found is not None
    assert (found.tenant, found.name) == ("acme", "alice")
    assert KeyRing((), "keys").needed
    assert KeyRing((), "none").needed is False


def test_a_store_that_has_lost_its_keys_lets_nobody_in(store: Store) -> None:
    ring = KeyRing((), None)
    key = store.api_keys.create("acme", "alice")
    ring.refresh(store.api_keys)
    assert ring.find(f"Bearer {key}") is not None
    store.client.flushdb()
    ring.refresh(store.api_keys)
    assert ring.needed
    assert ring.find(f"Bearer {key}") is None


def test_a_stored_key_is_not_called_unknown_before_the_store_was_read(
    stores: dict[str, Any], tmp_path: Path
) -> None:
    away = {"redis_url": f"unix://{tmp_path}/none.sock", "redis_patience": "0"}
    with running_api(Settings(**(stores | away | {"api_keys": "alice:key-one"}))) as api:
        assert status(api, None) == 401
        answer = httpx2.get(f"{api.url}/v1/shapes", headers={"Authorization": "Bearer isomatch_x"})
        problem(answer, 503, "store-away")
        assert "API keys" in answer.text
        # A key of the settings is accepted, though the store is away.
        held = httpx2.get(f"{api.url}/v1/structures", headers={"Authorization": "Bearer key-one"})
        assert held.status_code == 200


def test_services_log_what_changes(store: Store) -> None:
    ring, keys = KeyRing((), None), store.api_keys
    before = structlog.get_config()
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.INFO))
    try:
        with structlog.testing.capture_logs() as logged:
            keys.create("acme", "early")
            ring.refresh(keys)
            assert logged == []  # the command has logged it
            secret = keys.create("acme", "alice")
            ring.refresh(keys)
            keys.rotate("acme", "alice", timedelta(hours=1))
            ring.refresh(keys)
            keys.revoke("acme", "alice")
            ring.refresh(keys)
            store.client.flushdb()
            ring.refresh(keys)
    finally:
        structlog.configure(**before)
    assert [(line["event"], line["name"]) for line in logged] == [
        ("key created", "alice"),
        ("key rotated", "alice"),
        ("key revoked", "alice"),
        ("key revoked", "alice"),
        ("key lost by the store", "early"),
    ]
    assert secret not in str(logged)


def test_keys_of_a_newer_version_are_read(store: Store) -> None:
    store.api_keys.create("acme", "alice")
    (digest, value), *_ = store.client.hgetall(Keys.API_KEYS).items()
    newer = json.loads(value) | {"scopes": ["read"]}
    store.client.hset(Keys.API_KEYS, digest, json.dumps(newer))
    assert [key.name for key in store.api_keys.all()] == ["alice"]


def test_settings_that_contradict_each_other_are_refused() -> None:
    with pytest.raises(ValidationError) as refusal:
        Settings(api_keys="alice:key-one", auth="none")
    (error,) = refusal.value.errors()
    assert error["loc"] == ("auth",)
    assert "key-one" not in error["msg"]
