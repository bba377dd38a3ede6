"""``/metrics``."""

from fastapi import APIRouter, Request, Response
from prometheus_client.exposition import choose_encoder

from service.state import ServiceOf

router = APIRouter(tags=["health"])


@router.get(
    "/metrics",
    response_class=Response,
    responses={
        200: {
            "description": "In the text format of Prometheus or of OpenMetrics",
            "content": {"text/plain": {"schema": {"type": "string"}}},
        }
    },
    operation_id="metrics",
)
def metrics(service: ServiceOf, request: Request) -> Response:
    """Tell Prometheus of queues, workers, jobs, spectra and requests."""
    encode, media_type = choose_encoder(request.headers.get("accept", ""))
    return Response(encode(service.metrics), headers={"Content-Type": media_type})
