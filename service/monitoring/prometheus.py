"""``/metrics``."""

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
def metrics(service: ServiceOf, request: Request) -> Response:
    """Return metrics of queues, workers, jobs, spectra and requests for Prometheus."""
    encode, media_type = choose_encoder(request.headers.get("accept", ""))
    return Response(encode(service.metrics), headers={"Content-Type": media_type})
