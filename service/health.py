"""Probes."""

from fastapi import APIRouter
from pydantic import BaseModel, Field
from redis.exceptions import ResponseError

from service.http import NotReady, responses
from service.state import ServiceOf

router = APIRouter(tags=["health"])


class Health(BaseModel):
    """A process that answers."""

    status: str = Field(examples=["ok"])


class Readiness(Health):
    """What is needed to compute is there."""

    workers: int = Field(description="Workers that are alive and warm.")


@router.get("/health/live", operation_id="health_live")
async def live() -> Health:
    """Tell that the API process is alive."""
    return Health(status="ok")


@router.get("/health/ready", responses=responses(NotReady), operation_id="health_ready")
def ready(service: ServiceOf) -> Readiness:
    """Tell whether the store takes jobs, workers are there to run them, and nobody stops us."""
    if service.closing.is_set():
        raise NotReady("The service is stopping.")
    try:
        service.store.check()
    except ResponseError as error:
        raise NotReady(f"The store answers and takes nothing: {error}") from error
    workers, needed = service.queue.workers(), service.settings.ready_workers
    if workers < needed:
        raise NotReady(
            f"{workers} workers are ready of the {needed} that are needed (ISOMATCH_READY_WORKERS);"
            " those just started warm up first, and `python -m worker` starts one."
        )
    return Readiness(status="ok", workers=workers)
