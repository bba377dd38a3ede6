"""Every key the application uses in Redis, apart from those of RQ (which begin with ``rq:``).

Running systems hold data under these keys: the strings stay when a function here is renamed. So
``trace`` stands for a tombstone, ``turns`` for time slices, ``parts`` for chunks, ``tallies`` for
counters and ``order`` for an idempotency record.

A *reference* is a hash that names a blob (:mod:`broker.store.blobs`).
"""

from typing import Final

PREFIX: Final = "isomatch:"

SHAPES: Final = PREFIX + "shapes"
"""Sorted set of shape ids by time of creation."""

PROTOTYPES: Final = PREFIX + "prototypes"
"""Sorted set of prototype ids by time of creation."""

JOBS: Final = PREFIX + "jobs"
"""Sorted set of the listed jobs' ids by time of creation."""

ACTIVE_JOBS: Final = PREFIX + "jobs:active"
"""Sorted set of the ids of all jobs that have not ended, listed or not, by time of creation."""

UNSEEN_JOBS: Final = PREFIX + "jobs:suspects"
"""Hash of active jobs that RQ does not know: id to the time this was first noticed."""

RECOVERY: Final = PREFIX + "recovery"
"""Lock of the process that looks for lost jobs."""

COUNTERS: Final = PREFIX + "tallies"
"""Hash of counters over all processes: jobs, failures, times."""

WEBHOOKS: Final = PREFIX + "webhooks"
"""Sorted set of the ids of ended jobs whose webhook is not delivered, by when it is due."""

READY: Final = PREFIX + "ready"
"""Written to check that the store accepts writes."""

BLOB_OWNER: Final = PREFIX + "blobs:owner"
"""Hash: the id that marks the blob store as that of this Redis, and whether the mark was set."""

BLOB_SWEEP: Final = PREFIX + "blobs:sweep"
"""Number of folders of the blob store that were swept."""

SPECTRUM_COUNTERS: Final = PREFIX + "spectra:counters"
"""Hash of counters: spectra computed, spectra taken from the cache."""

CACHED_SPECTRA: Final = PREFIX + "cache:spectra"
"""Sorted set of cached spectra by time of last use."""

CACHED_SIZES: Final = PREFIX + "cache:sizes"
"""Hash of cached spectra's sizes in bytes; the field ``total`` holds their sum."""


def shape(shape_id: str) -> str:
    """Record of a shape, JSON."""
    return f"{PREFIX}shape:{shape_id}"


def shape_upload(shape_id: str) -> str:
    """The uploaded bytes of a shape, a reference."""
    return f"{PREFIX}shape:{shape_id}:upload"


def shape_mesh(shape_id: str) -> str:
    """The repaired mesh of a shape, a reference to npz."""
    return f"{PREFIX}shape:{shape_id}:mesh"


def shape_geometry(shape_id: str) -> str:
    """The geometry of a shape that the page draws, a reference to gzip."""
    return f"{PREFIX}shape:{shape_id}:geometry"


def shape_tombstone(shape_id: str) -> str:
    """Tombstone of a shape: outlives its record unless the shape was deleted."""
    return f"{PREFIX}shape:{shape_id}:trace"


def prototype(prototype_id: str) -> str:
    """Record of a prototype, JSON."""
    return f"{PREFIX}prototype:{prototype_id}"


def prototype_archive(prototype_id: str) -> str:
    """The archive of a prototype, a reference to npz."""
    return f"{PREFIX}prototype:{prototype_id}:archive"


def prototype_geometry(prototype_id: str) -> str:
    """Points and a surface of a prototype, a reference to JSON in gzip."""
    return f"{PREFIX}prototype:{prototype_id}:geometry"


def prototype_tombstone(prototype_id: str) -> str:
    """Tombstone of a prototype: outlives its record unless the prototype was deleted."""
    return f"{PREFIX}prototype:{prototype_id}:trace"


def prototypes_named(name: str) -> str:
    """Sorted set of the ids of the prototypes of one name by time of creation."""
    return f"{PREFIX}prototypes:named:{name}"


def prototype_versions(name: str) -> str:
    """Last version number of a name."""
    return f"{PREFIX}prototypes:versions:{name}"


def attributes(attributes_id: str) -> str:
    """Record of an attribute file, JSON."""
    return f"{PREFIX}attributes:{attributes_id}"


def attributes_file(attributes_id: str) -> str:
    """The uploaded bytes of an attribute file, a reference."""
    return f"{PREFIX}attributes:{attributes_id}:file"


def attributes_tombstone(attributes_id: str) -> str:
    """Tombstone of an attribute file: outlives its record unless the file was deleted."""
    return f"{PREFIX}attributes:{attributes_id}:trace"


def candidate(upload_id: str, file_type: str, job_id: str) -> str:
    """Uploaded bytes that a job validates, a reference."""
    return f"{PREFIX}candidate:{upload_id}:{file_type}:{job_id}"


def candidate_job(upload_id: str, file_type: str) -> str:
    """Id of the job that validates an upload."""
    return f"{PREFIX}candidate:{upload_id}:{file_type}:job"


def deferred(upload_id: str) -> str:
    """Id of the validation job of an upload that was answered before the job ended."""
    return f"{PREFIX}deferred:{upload_id}"


def job(job_id: str) -> str:
    """Record and state of a job, hash."""
    return f"{PREFIX}job:{job_id}"


def job_tombstone(job_id: str) -> str:
    """Tombstone of a job: outlives its record."""
    return f"{PREFIX}job:{job_id}:trace"


def job_result(job_id: str) -> str:
    """Result of a job, a reference to JSON in gzip."""
    return f"{PREFIX}job:{job_id}:result"


def job_picture(job_id: str, variant: str = "") -> str:
    """Picture of a job's result, or its result in another format, by the variant; a reference."""
    return f"{PREFIX}job:{job_id}:picture" + (f":{variant}" if variant else "")


def picture_job(job_id: str, variant: str = "") -> str:
    """Id of the job that draws such a picture."""
    return f"{job_picture(job_id, variant)}:job"


def job_chunks(job_id: str) -> str:
    """Stage, counts and times of a job that is done in time slices, hash."""
    return f"{PREFIX}job:{job_id}:parts"


def chunk_holders(job_id: str) -> str:
    """Holders of the present stage's chunks, hash."""
    return f"{PREFIX}job:{job_id}:parts:holders"


def chunk_results(job_id: str, stage: str) -> str:
    """Results of a stage's chunks that are done, hash."""
    return f"{PREFIX}job:{job_id}:parts:{stage}"


def stage_input(job_id: str, stage: str) -> str:
    """Common input of a stage's chunks."""
    return f"{PREFIX}job:{job_id}:parts:{stage}:input"


def time_slices(job_id: str) -> str:
    """Set of the ids of the queued and running time slices of a job."""
    return f"{PREFIX}job:{job_id}:turns"


def job_arrays(job_id: str) -> str:
    """Result of a job as arrays, a reference to npz."""
    return f"{PREFIX}job:{job_id}:arrays"


def job_summary(job_id: str) -> str:
    """Result of a match in brief, JSON."""
    return f"{PREFIX}job:{job_id}:summary"


def idempotency_record(name: str) -> str:
    """Digest of a request with an idempotency key, and its job's id."""
    return f"{PREFIX}order:{name}"


def queued_by(caller: str | None) -> str:
    """Sorted set of the ids of the jobs that a caller has queued, by time of admission."""
    return f"{PREFIX}queued:{caller or ''}"


def jobs_in(state: str) -> str:
    """Sorted set of the listed jobs' ids in one state, by time of creation."""
    return f"{PREFIX}jobs:{state}"


def jobs_of(name: str) -> str:
    """Sorted set of the ids of the listed jobs of a shape or a prototype, by time of creation."""
    return f"{PREFIX}jobs:of:{name}"


def spectrum_job(spectrum: object) -> str:
    """Id of the job that was queued to compute a spectrum."""
    return f"{PREFIX}spectrum:{spectrum}:job"


def spectrum_lock(spectrum: object) -> str:
    """Lock of the process that computes a spectrum."""
    return f"{PREFIX}spectrum:{spectrum}:lock"


def cache_circuit(machine: str) -> str:
    """State of a machine's circuit breaker of a cache with a Redis of its own."""
    return f"{PREFIX}cache:away:{machine}"


def cached_spectrum(spectrum: object) -> str:
    """A cached spectrum, npz; in the cache's own Redis where there is one."""
    return f"{PREFIX}cache:spectrum:{spectrum}"
