"""``/metrics``."""

from anyio import to_thread
from fastapi import APIRouter, Request, Response
from prometheus_client.exposition import choose_encoder

from service.dependencies import ServiceOf

router = APIRouter(tags=["health"])


@router.get(
    "/metrics",
    response_class=Response,
    responses={
        200: {
            "description": "Metrics in the text format of Prometheus or OpenMetrics",
            "content": {"text/plain": {"schema": {"type": "string"}}},
        }
    },
    operation_id="metrics",
)
async def metrics(service: ServiceOf, request: Request) -> Response:
    """Return metrics of queues, workers, jobs, spectra and requests for Prometheus."""
    encode, media_type = choose_encoder(request.headers.get("accept", ""))
    # The threads of other requests may all wait for Redis.
    text = await to_thread.run_sync(encode, service.metrics, limiter=service.scraping)
    return Response(text, headers={"Content-Type": media_type})
