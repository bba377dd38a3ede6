"""Probes."""

from typing import Literal

from fastapi import APIRouter
from pydantic import BaseModel, Field
from redis.exceptions import ResponseError

from broker.blobs import BlobError
from broker.store import EvictsRecords
from service.dependencies import ServiceOf
from service.http import NotReady, responses
from service.release import VERSION

router = APIRouter(tags=["health"])


class Health(BaseModel):
    """State of the API process."""

    status: Literal["ok"] = Field(description="That it answers.")
    version: str = Field(description="Version of the service.", examples=[VERSION])


class Readiness(BaseModel):
    """Readiness to run jobs."""

    status: Literal["ok"] = Field(description="That it is ready.")
    workers: int = Field(description="Number of workers that are alive and warmed up.")


@router.get("/health/live", operation_id="health_live")
async def live() -> Health:
    """Report that the API process is alive."""
    return Health(status="ok", version=VERSION)


@router.get("/health/ready", responses=responses(NotReady), operation_id="health_ready")
def ready(service: ServiceOf) -> Readiness:
    """Report whether the store accepts jobs and enough workers are ready to run them."""
    if service.closing.is_set():
        raise NotReady("The service is stopping.")
    try:
        service.store.check()
    except EvictsRecords as error:
        raise NotReady(str(error)) from error
    except ResponseError as error:
        raise NotReady(f"The store refuses writes: {error}") from error
    except BlobError as error:
        raise NotReady(f"Nothing can be stored: {error}") from error
    workers, needed = service.queue.workers(), service.settings.ready_workers
    if workers < needed:
        raise NotReady(
            f"{workers} of {needed} needed workers are ready (ISOMATCH_READY_WORKERS); workers warm"
            " up after their start, and `python -m worker` starts one."
        )
    return Readiness(status="ok", workers=workers)
