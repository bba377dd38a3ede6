"""Settings of the worker."""

from pydantic import Field

from broker.environment import FROM_ENVIRONMENT, LogLevel
from broker.queue import QueueSettings
from broker.store import StoreSettings
from broker.webhooks import WebhookSettings


class WorkerSettings(StoreSettings, QueueSettings, WebhookSettings):
    """Settings of the worker, from ``ISOMATCH_*``."""

    model_config = FROM_ENVIRONMENT

    log_level: LogLevel = Field(default="INFO", description="Lowest level that is logged.")
    job_memory_mb: int = Field(
        default=8192, ge=0, description="MiB of memory one job may take; 0 for no limit."
    )
    worker_patience: float = Field(
        default=60.0,
        ge=0,
        description="Seconds a worker waits while Redis, or object storage, cannot be reached.",
    )
