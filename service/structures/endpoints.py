"""``/v1/structures``."""

from fastapi import APIRouter

from broker.contracts import Structures, catalogue
from service.http import InvalidRequest, responses

router = APIRouter(prefix="/v1/structures", tags=["structures"])


@router.get("", responses=responses(InvalidRequest), operation_id="list_structures")
def list_structures() -> Structures:
    """List the metrics and descriptors that can be chosen, with invariances and parameters."""
    return catalogue()
