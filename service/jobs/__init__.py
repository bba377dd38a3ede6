"""Jobs: requesting them, following and cancelling them, and their results."""

from service.jobs import endpoints, maps, pictures, results
from service.jobs.endpoints import LONGEST_WAIT
from service.jobs.followed import Event, FollowedJobs, Name
from service.jobs.lookup import (
    JobId,
    check_kept,
    job_with_result,
    json_answer,
    open_result,
    stored_job,
)
from service.jobs.pictures import NEEDED, presented
from service.jobs.requests import (
    IdempotencyKey,
    JobOrderOf,
    JobRequest,
    answers,
)
from service.jobs.results import BYTES, ERRORS
from service.jobs.schemas import Job
from service.jobs.webhooks import router as webhooks_router

ROUTERS = (endpoints.router, results.router, pictures.router, maps.router)

__all__ = [
    "BYTES",
    "ERRORS",
    "LONGEST_WAIT",
    "NEEDED",
    "ROUTERS",
    "Event",
    "FollowedJobs",
    "IdempotencyKey",
    "Job",
    "JobId",
    "JobOrderOf",
    "JobRequest",
    "Name",
    "answers",
    "check_kept",
    "job_with_result",
    "json_answer",
    "open_result",
    "presented",
    "stored_job",
    "webhooks_router",
]
