"""The queue, its lanes, and the limits of the jobs in it."""

from dataclasses import dataclass
from typing import Final

from pydantic import Field
from pydantic_settings import BaseSettings

from broker.contracts import JobKind
from broker.environment import FROM_ENVIRONMENT

JOBS: Final = "matches"
"""The queue of all jobs. Running systems hold jobs under this name, from when there were three."""

QUEUES: Final = ("interactive", "structures", JOBS)
"""The queues that workers serve: the first two may hold jobs of an API of an older version."""


@dataclass(frozen=True)
class Lane:
    """What jobs of some kinds of one tenant count in the queue; each tenant has its own lanes.

    Parameters
    ----------
    name
        Its name.
    cost
        What a job takes of the lane's share: about its time, in times of a match.
    lead
        How far its jobs may come before those of lanes that had their share.
    """

    name: str
    cost: float
    lead: float


INTERACTIVE: Final = Lane("interactive", 1 / 16, 1.0)
"""A request waits for the job, or it is short: sixteen may come before any match."""

STRUCTURES: Final = Lane("structures", 1 / 2, 1.0)
"""Spectra that matches will need, two for each."""

MATCHES: Final = Lane("matches", 1.0, 0.0)

LANE_OF: Final = {
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
        default=1000,
        ge=0,
        description="Jobs a caller may have queued at a time, and as many uploads to be validated;"
        " 0 for any number.",
    )

    def timeout(self, kind: JobKind) -> int:
        """Return the seconds a job of this kind may take."""
        interactive = LANE_OF[kind] is INTERACTIVE
        return self.interactive_timeout if interactive else self.job_timeout
