"""Probes, and the page at the root."""

from fastapi import APIRouter
from fastapi.responses import HTMLResponse
from pydantic import BaseModel, Field
from redis.exceptions import ResponseError

from service.problems import NotReady, responses
from service.state import ServiceOf

router = APIRouter(tags=["health"])

_INDEX = """<!doctype html>
<html lang="en">
<head><meta charset="utf-8"><title>isomatch</title></head>
<body>
<h1>isomatch</h1>
<p>Minimum-distortion correspondences of non-rigid shapes, with certificates of optimality.</p>
<ul>
<li><a href="/docs">The API, to be tried out</a></li>
<li><a href="/openapi.json">The API as an OpenAPI document</a></li>
<li><a href="/v1/shapes">Shapes</a></li>
<li><a href="/v1/jobs">Jobs</a></li>
<li><a href="/health/ready">Whether all is ready</a></li>
</ul>
</body>
</html>
"""


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
        raise NotReady(f"{workers} workers are ready of the {needed} that are needed.")
    return Readiness(status="ok", workers=workers)


@router.get("/", include_in_schema=False)
async def index() -> HTMLResponse:
    """Show where to go from here."""
    return HTMLResponse(_INDEX)
