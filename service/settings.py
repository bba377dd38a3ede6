"""Settings of the API process."""

import os
from pathlib import Path

from pydantic import Field, ValidationInfo, field_validator

from broker.environment import FROM_ENVIRONMENT, LogLevel
from broker.queue import QueueSettings
from broker.store import StoreSettings
from broker.webhooks import WebhookSettings
from service.http import ApiKeys, Auth, Hosts, Origins


class Settings(StoreSettings, QueueSettings, WebhookSettings):
    """From ``ISOMATCH_*``; an ``.env`` file is not read."""

    model_config = FROM_ENVIRONMENT

    host: str = Field(default="127.0.0.1", description="Address to listen on.")
    port: int = Field(default=8000, ge=0, le=65535, description="Port; 0 for a free one.")
    data_dir: Path = Field(
        default=Path("isomatch-data"),
        description="Where the private Redis keeps its data, and by default the blobs.",
    )
    workers: int | None = Field(
        default=None,
        ge=0,
        description="Workers to start; default: one per core, none where ISOMATCH_REDIS_URL is"
        " set.",
    )
    ready_workers: int = Field(
        default=1,
        ge=0,
        description="Workers that must be alive for /health/ready; 0 where workers are started"
        " only when there are jobs.",
    )
    max_upload_bytes: int = Field(
        default=256 * 1024**2, ge=1, description="Largest upload that is accepted, in bytes."
    )
    body_patience: float = Field(
        default=30.0,
        gt=0,
        description="Seconds a request waits for the next piece of its body, or for space for it.",
    )
    drain_seconds: int = Field(
        default=3,
        ge=1,
        description="Seconds that open requests, such as uploads, have to end when the service"
        " stops.",
    )
    validation_wait: float = Field(
        default=30.0, ge=0, description="Seconds an upload waits for its turn and its validation."
    )
    picture_wait: float = Field(
        default=60.0, ge=0, description="Seconds a request waits for its picture."
    )
    redis_patience: float = Field(
        default=2.0,
        ge=0,
        description="Seconds a request waits while Redis, or object storage, cannot be reached.",
    )
    api_keys: ApiKeys = Field(
        default=(),
        repr=False,
        description="Who may call, as NAME:KEY or NAME:sha256:DIGEST, separated by commas; names"
        " may be preceded by that of a tenant, TENANT/NAME.",
    )
    auth: Auth | None = Field(
        default=None,
        description="Whether calls need an API key: keys or none. Default: keys where"
        " ISOMATCH_API_KEYS is set, or a key was ever created.",
    )
    allowed_hosts: Hosts = Field(
        default=(),
        description="Further host names to which the service answers without API keys, such as"
        " that of a proxy, separated by commas. It always answers to IP addresses, names that"
        " public DNS does not have, and ISOMATCH_HOST.",
    )
    cors_origins: Origins = Field(
        default=(),
        description="Origins of web pages that may call the API with a key (CORS), such as"
        " https://app.example.org, separated by commas. Without API keys no page of another site"
        " may.",
    )
    idempotency_ttl: int = Field(
        default=86400, ge=1, description="Seconds an Idempotency-Key is remembered."
    )
    events_lifetime: float = Field(
        default=300.0,
        gt=0,
        description="Seconds after which a stream of events ends; clients reconnect by themselves.",
    )
    events_heartbeat: float = Field(
        default=15.0,
        gt=0,
        description="Seconds of silence after which a stream of events sends a comment.",
    )
    log_level: LogLevel = Field(default="INFO", description="Lowest level that is logged.")

    @field_validator("auth")
    @classmethod
    def _means_one_thing(cls, auth: Auth | None, info: ValidationInfo) -> Auth | None:
        if auth == "none" and info.data.get("api_keys"):
            raise ValueError("none, but ISOMATCH_API_KEYS has keys; unset one of them")
        return auth

    @field_validator("cors_origins")
    @classmethod
    def _with_keys(cls, origins: Origins, info: ValidationInfo) -> Origins:
        if origins and info.data.get("auth") == "none":
            raise ValueError("pages of other sites need API keys; set ISOMATCH_AUTH=keys")
        return origins

    @property
    def worker_count(self) -> int:
        """Number of workers this process starts."""
        if self.workers is not None:
            return self.workers
        return _cores() if self.redis_url is None else 0


def _cores() -> int:
    # A process may be confined to some of the machine's cores.
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
