"""The compose file: every container confined, the stores apart, names that are read."""

from typing import Any

import pytest

from broker.tracing import ENDPOINTS
from service.settings import Settings
from service.standalone import EmbeddedServer
from tests.containers.manifests import DOCKER, OBJECT_STORAGE, Json, compose, settings_names, stages
from worker.settings import WorkerSettings

SERVICES: dict[str, Json] = compose()["services"]
STORES = ("queue", "cache")


@pytest.mark.parametrize("name", SERVICES)
def test_every_container_is_confined(name: str) -> None:
    service = SERVICES[name]
    assert service["read_only"] is True
    assert service["cap_drop"] == ["ALL"]
    assert service["security_opt"] == ["no-new-privileges:true"]
    assert service["mem_limit"]
    assert service["restart"] == "unless-stopped"
    if name in STORES:
        assert service["user"] == "999:999"
        assert service["healthcheck"]["test"][:2] == ["CMD", "valkey-cli"]
    else:
        # Who the images run as, and how they are checked, is said in them.
        target = service["build"]["target"]
        words = [word for word, _ in stages()[target]]
        assert {"USER", "HEALTHCHECK"} <= set(words)


def test_nothing_listens_but_the_api_and_that_on_this_machine_only() -> None:
    assert {name for name, each in SERVICES.items() if "ports" in each} == {"api"}
    assert SERVICES["api"]["ports"] == ["${ISOMATCH_LISTEN:-127.0.0.1:8000}:8000"]
    assert ("EXPOSE", "8000") in stages()["api"]
    assert compose()["networks"]["back"] == {"internal": True}
    assert all(SERVICES[name]["networks"] == ["back"] for name in STORES)


def test_api_and_workers_wait_for_stores_that_answer() -> None:
    for name in ("api", "worker"):
        needs = SERVICES[name]["depends_on"]
        # Without the cache they work, more slowly.
        conditions = {"queue": "service_healthy", "cache": "service_started"}
        assert needs == {store: {"condition": state} for store, state in conditions.items()}


def test_settings_have_the_names_that_are_read() -> None:
    for name, read in (
        ("api", settings_names(Settings)),
        ("worker", settings_names(WorkerSettings)),
    ):
        assert set(SERVICES[name]["environment"]) <= read | {*OBJECT_STORAGE, *ENDPOINTS}
        assert "blobs:/blobs" in SERVICES[name]["volumes"]
    agreed = SERVICES["worker"]["environment"].items() & SERVICES["api"]["environment"].items()
    same = {"ISOMATCH_REDIS_URL", "ISOMATCH_BLOB_URL", "ISOMATCH_CACHE_URL"}
    assert {*same, *OBJECT_STORAGE, "ISOMATCH_JOB_TIMEOUT"} <= dict(agreed).keys()


def test_what_is_not_set_of_object_storage_stays_unset() -> None:
    for name in ("api", "worker"):
        # Null is passed on as it is outside; "" would be a key, or an address, of its own.
        assert {SERVICES[name]["environment"][variable] for variable in OBJECT_STORAGE} == {None}


def test_who_may_call_and_what_tenants_may_have_reaches_the_containers() -> None:
    quotas = {"ISOMATCH_TENANT_SHAPES", "ISOMATCH_TENANT_BYTES", "ISOMATCH_TENANT_JOBS"}
    api, worker = (set(SERVICES[name]["environment"]) for name in ("api", "worker"))
    # A setting that is not passed on would leave the service open without a word.
    assert {"ISOMATCH_AUTH", "ISOMATCH_API_KEYS", "ISOMATCH_ALLOWED_HOSTS", *quotas} <= api
    assert quotas <= worker


def default(value: str) -> str:
    """What a variable of the compose file is, where the environment does not say."""
    return value.split(":-")[1].removesuffix("}")


def test_every_setting_reaches_the_containers_that_read_it() -> None:
    # These are the image's: what is listened to, and what is started.
    fixed = {f"ISOMATCH_{name}" for name in ("HOST", "PORT", "WORKERS", "DATA_DIR")}
    for service, read in (("api", Settings), ("worker", WorkerSettings)):
        assert settings_names(read) - fixed <= set(SERVICES[service]["environment"])


def test_defaults_are_those_of_the_settings() -> None:
    others = {"ISOMATCH_CACHE_BYTES", "ISOMATCH_JOB_MEMORY_MB", "ISOMATCH_DRAIN_SECONDS"}
    for service in ("api", "worker"):
        for name, value in SERVICES[service]["environment"].items():
            if not (name.endswith("_URL") or name in (*others, *OBJECT_STORAGE, *ENDPOINTS)):
                assert value == f"${{{name}:-}}", "an empty variable is none"


def options(name: str) -> dict[str, Any]:
    words = SERVICES[name]["command"]
    assert words[0] == "valkey-server"
    return {
        key.removeprefix("--"): value for key, value in zip(words[1::2], words[2::2], strict=True)
    }


def test_the_queue_loses_nothing_and_the_cache_makes_room() -> None:
    queue, cache = options("queue"), options("cache")
    assert queue["appendonly"] == "yes"
    assert queue["maxmemory-policy"] == "noeviction"
    assert SERVICES["queue"]["volumes"] == ["queue:/data"]
    assert cache["appendonly"] == "no"
    assert cache["maxmemory-policy"] == "allkeys-lfu"
    budget = int(default(SERVICES["worker"]["environment"]["ISOMATCH_CACHE_BYTES"]))
    assert default(cache["maxmemory"]) == "2gb"
    assert budget < 2 * 1024**3


def test_the_options_of_the_private_server_are_the_same() -> None:
    private = dict(zip(*[iter(EmbeddedServer(DOCKER)._options())] * 2, strict=True))
    for name in ("appendonly", "appendfsync", "save", "maxmemory-policy"):
        assert private[f"--{name}"] == options("queue")[name]


def test_a_job_fails_before_its_container_is_killed() -> None:
    worker = SERVICES["worker"]
    limit = int(default(worker["mem_limit"]).removesuffix("g")) * 1024
    assert int(default(worker["environment"]["ISOMATCH_JOB_MEMORY_MB"])) <= 0.75 * limit
    assert "/tmp:size=256m,mode=1777" in worker["tmpfs"]


def test_an_api_that_stops_has_time_for_its_uploads() -> None:
    api = SERVICES["api"]
    drain = int(default(api["environment"]["ISOMATCH_DRAIN_SECONDS"]))
    assert drain + 5 <= int(api["stop_grace_period"].removesuffix("s"))


def test_who_reaches_the_stores_from_outside_knows_a_password() -> None:
    remote = compose(DOCKER / "compose.remote.yaml")["services"]
    assert set(remote) == set(STORES)
    assert ":?" in remote["queue"]["environment"]["REDISCLI_AUTH"]
    for store in STORES:
        assert remote[store]["ports"][0].startswith("${ISOMATCH_PRIVATE_ADDRESS:?")
