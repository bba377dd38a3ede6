"""The queues, and the limits of the jobs in them.

Three queues, served in this order: ``interactive`` (a request waits for the job, or it is short),
``structures`` (spectra that matches will need), ``matches``.
"""

from typing import Final

from pydantic import Field
from pydantic_settings import BaseSettings

from broker.contracts import JobKind
from broker.environment import FROM_ENVIRONMENT

INTERACTIVE: Final = "interactive"
STRUCTURES: Final = "structures"
MATCHES: Final = "matches"
QUEUES: Final = (INTERACTIVE, STRUCTURES, MATCHES)

QUEUE_OF: Final = {
    JobKind.VALIDATION: INTERACTIVE,
    JobKind.PROTOTYPE_VALIDATION: INTERACTIVE,
    JobKind.ATTRIBUTES_VALIDATION: INTERACTIVE,
    JobKind.PICTURE: INTERACTIVE,
    JobKind.TRANSFER: INTERACTIVE,
    JobKind.WEBHOOK: INTERACTIVE,
    JobKind.SPECTRUM: STRUCTURES,
    JobKind.MATCH: MATCHES,
    JobKind.BATCH: MATCHES,
    JobKind.DISSIMILARITIES: MATCHES,
    JobKind.PROTOTYPE: MATCHES,
    JobKind.REGISTRATION: MATCHES,
    JobKind.CONSISTENT_MAPS: MATCHES,
    JobKind.TIME_SLICE: MATCHES,
}


class QueueSettings(BaseSettings):
    """Number of jobs, timeouts and heartbeats; from ``ISOMATCH_*``."""

    model_config = FROM_ENVIRONMENT

    job_timeout: int = Field(
        default=3600, ge=1, description="Seconds a match or a spectrum may take."
    )
    interactive_timeout: int = Field(
        default=300, ge=1, description="Seconds a validation, a transfer or a picture may take."
    )
    heartbeat: int = Field(
        default=5,
        ge=1,
        le=10,
        description="Seconds between two heartbeats of a worker that is busy; after four without"
        " one its job is given to another. API and workers need the same.",
    )
    max_queued_jobs: int = Field(
        default=1000, ge=0, description="Jobs a caller may have queued at a time; 0 for any number."
    )

    def timeout(self, kind: JobKind) -> int:
        """Return the seconds a job of this kind may take."""
        interactive = QUEUE_OF[kind] == INTERACTIVE
        return self.interactive_timeout if interactive else self.job_timeout
