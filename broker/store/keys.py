"""Every key the application uses in Redis, apart from those of RQ (which begin with ``rq:``).

Each tenant has its own keys: whoever looks under them finds what is the tenant's, and nothing else.
Those of :data:`DEFAULT_TENANT`, which a service without API keys works for, have no tenant's name,
so that it owns what was stored before there were tenants.

Running systems hold data under these keys: the strings stay when a name here is changed. So
``trace`` stands for a tombstone, ``turns`` for time slices, ``parts`` for chunks, ``tallies`` for
counters, ``suspects`` for unseen jobs and ``order`` for an idempotency record.

A *reference* is a hash that names a blob (:mod:`broker.store.blobs`).
"""

import re
from dataclasses import dataclass
from typing import ClassVar, Final, Self

from broker.contracts import DEFAULT_TENANT, TENANT_NAME, JobRecord

PREFIX: Final = "isomatch:"
_OWNED: Final = re.compile(re.escape(PREFIX) + r"tenant:([^:]+):")


@dataclass(frozen=True)
class Keys:
    """The keys of a tenant, and, as class attributes and static methods, those of all together.

    Parameters
    ----------
    tenant
        Its name.
    """

    tenant: str = DEFAULT_TENANT

    RECOVERY: ClassVar = PREFIX + "recovery"
    """Lock of the process that looks for lost jobs."""

    COUNTERS: ClassVar = PREFIX + "tallies"
    """Hash of counters over all processes: jobs, failures, times."""

    READY: ClassVar = PREFIX + "ready"
    """Written to check that the store accepts writes."""

    LISTING_SWEEP: ClassVar = PREFIX + "listings:sweep"
    """Number of the listing that is swept next, and the cursor in it."""

    BLOB_OWNER: ClassVar = PREFIX + "blobs:owner"
    """Hash: the id that marks the blob store as that of this Redis, and whether it was set."""

    BLOB_SWEEP: ClassVar = PREFIX + "blobs:sweep"
    """Number of folders of the blob store that were swept."""

    SPECTRUM_COUNTERS: ClassVar = PREFIX + "spectra:counters"
    """Hash of counters: spectra computed, spectra taken from the cache."""

    CACHED_SPECTRA: ClassVar = PREFIX + "cache:spectra"
    """Sorted set of cached spectra by time of last use."""

    CACHED_SIZES: ClassVar = PREFIX + "cache:sizes"
    """Hash of cached spectra's sizes in bytes; the field ``total`` holds their sum."""

    API_KEYS: ClassVar = PREFIX + "keys"
    """Hash of the created API keys, JSON, by the SHA-256 of each."""

    API_KEYS_EVER: ClassVar = PREFIX + "keys:ever"
    """Exists from when the first API key was created."""

    QUOTAS: ClassVar = PREFIX + "quotas"
    """Hash of the quotas of tenants that have their own, JSON, by the tenant's name."""

    TENANTS: ClassVar = PREFIX + "tenants"
    """Set of the names of the tenants that have had jobs, without the default one."""

    def __post_init__(self) -> None:
        """Check the name, which becomes a part of keys and of the paths of blobs."""
        if not TENANT_NAME.fullmatch(self.tenant):
            raise ValueError(f"no tenant may be named {self.tenant!r}")

    @property
    def prefix(self) -> str:
        """What all keys of the tenant begin with."""
        if self.tenant == DEFAULT_TENANT:
            return PREFIX
        return f"{PREFIX}tenant:{self.tenant}:"

    @property
    def shapes(self) -> str:
        """Sorted set of shape ids by time of creation."""
        return self.prefix + "shapes"

    @property
    def prototypes(self) -> str:
        """Sorted set of prototype ids by time of creation."""
        return self.prefix + "prototypes"

    @property
    def jobs(self) -> str:
        """Sorted set of the listed jobs' ids by time of creation."""
        return self.prefix + "jobs"

    @property
    def active_jobs(self) -> str:
        """Sorted set of the ids of all jobs that have not ended, by time of creation."""
        return self.prefix + "jobs:active"

    @property
    def unseen_jobs(self) -> str:
        """Hash of active jobs that RQ does not know: id to the time this was first noticed."""
        return self.prefix + "jobs:suspects"

    @property
    def webhooks(self) -> str:
        """Sorted set of the ids of ended jobs whose webhook is not delivered, by when it is due."""
        return self.prefix + "webhooks"

    @property
    def delivery(self) -> str:
        """Id of the job that delivers a webhook; one of the tenant is delivered at a time."""
        return self.prefix + "webhooks:delivery"

    @property
    def held(self) -> str:
        """Sorted set by size of the keys of references to the tenant's blobs, and of listed jobs.

        With ``:sum``, the sum of the sizes in bytes, as long as it is known; with ``:counted``,
        exists for a while after what has expired was looked for.
        """
        return self.prefix + "held"

    @property
    def admitted(self) -> str:
        """Sorted set of the listed jobs' ids that have not ended, by time of admission."""
        return self.prefix + "admitted"

    @property
    def validating(self) -> str:
        """Sorted set of the ids of validations that have not ended, by time of admission."""
        return self.prefix + "validating"

    @classmethod
    def owning(cls, key: str) -> Self:
        """Return the keys of the tenant that a key belongs to."""
        found = _OWNED.match(key)
        return cls(DEFAULT_TENANT if found is None else found.group(1))

    def shape(self, shape_id: str) -> str:
        """Record of a shape, JSON."""
        return f"{self.prefix}shape:{shape_id}"

    def shape_upload(self, shape_id: str) -> str:
        """The uploaded bytes of a shape, a reference."""
        return f"{self.prefix}shape:{shape_id}:upload"

    def shape_mesh(self, shape_id: str) -> str:
        """The repaired mesh of a shape, a reference to npz."""
        return f"{self.prefix}shape:{shape_id}:mesh"

    def shape_geometry(self, shape_id: str) -> str:
        """The geometry of a shape that the page draws, a reference to gzip."""
        return f"{self.prefix}shape:{shape_id}:geometry"

    def shape_tombstone(self, shape_id: str) -> str:
        """Tombstone of a shape: outlives its record unless the shape was deleted."""
        return f"{self.prefix}shape:{shape_id}:trace"

    def prototype(self, prototype_id: str) -> str:
        """Record of a prototype, JSON."""
        return f"{self.prefix}prototype:{prototype_id}"

    def prototype_archive(self, prototype_id: str) -> str:
        """The archive of a prototype, a reference to npz."""
        return f"{self.prefix}prototype:{prototype_id}:archive"

    def prototype_geometry(self, prototype_id: str) -> str:
        """Points and a surface of a prototype, a reference to JSON in gzip."""
        return f"{self.prefix}prototype:{prototype_id}:geometry"

    def prototype_tombstone(self, prototype_id: str) -> str:
        """Tombstone of a prototype: outlives its record unless the prototype was deleted."""
        return f"{self.prefix}prototype:{prototype_id}:trace"

    def prototypes_named(self, name: str) -> str:
        """Sorted set of the ids of the prototypes of one name by time of creation."""
        return f"{self.prefix}prototypes:named:{name}"

    def prototype_versions(self, name: str) -> str:
        """Last version number of a name."""
        return f"{self.prefix}prototypes:versions:{name}"

    def attributes(self, attributes_id: str) -> str:
        """Record of an attribute file, JSON."""
        return f"{self.prefix}attributes:{attributes_id}"

    def attributes_file(self, attributes_id: str) -> str:
        """The uploaded bytes of an attribute file, a reference."""
        return f"{self.prefix}attributes:{attributes_id}:file"

    def attributes_tombstone(self, attributes_id: str) -> str:
        """Tombstone of an attribute file: outlives its record unless the file was deleted."""
        return f"{self.prefix}attributes:{attributes_id}:trace"

    def candidate(self, upload_id: str, file_type: str, job_id: str) -> str:
        """Uploaded bytes that a job validates, a reference."""
        return f"{self.prefix}candidate:{upload_id}:{file_type}:{job_id}"

    def candidate_job(self, upload_id: str, file_type: str) -> str:
        """Id of the job that validates an upload."""
        return f"{self.prefix}candidate:{upload_id}:{file_type}:job"

    def deferred(self, upload_id: str) -> str:
        """Id of the validation job of an upload that was answered before the job ended."""
        return f"{self.prefix}deferred:{upload_id}"

    def job(self, job_id: str) -> str:
        """Record and state of a job, hash."""
        return f"{self.prefix}job:{job_id}"

    def job_tombstone(self, job_id: str) -> str:
        """Tombstone of a job: outlives its record; that of a batch is the number of its matches."""
        return f"{self.prefix}job:{job_id}:trace"

    def job_result(self, job_id: str) -> str:
        """Result of a job, a reference to JSON in gzip."""
        return f"{self.prefix}job:{job_id}:result"

    def job_picture(self, job_id: str, variant: str = "") -> str:
        """Picture of a job's result, or the result in another format; a reference."""
        return f"{self.prefix}job:{job_id}:picture" + (f":{variant}" if variant else "")

    def job_pictures(self, job_id: str) -> str:
        """Set of the keys of the pictures of a job's result."""
        return f"{self.prefix}job:{job_id}:pictures"

    def picture_job(self, job_id: str, variant: str = "") -> str:
        """Id of the job that draws such a picture."""
        return f"{self.job_picture(job_id, variant)}:job"

    def job_chunks(self, job_id: str) -> str:
        """Stage, counts and times of a job that is done in time slices, or of a batch; hash."""
        return f"{self.prefix}job:{job_id}:parts"

    def chunk_holders(self, job_id: str) -> str:
        """Holders of the present stage's chunks, hash."""
        return f"{self.prefix}job:{job_id}:parts:holders"

    def chunk_results(self, job_id: str, stage: str) -> str:
        """Results of a stage's chunks that are done, hash."""
        return f"{self.prefix}job:{job_id}:parts:{stage}"

    def stage_input(self, job_id: str, stage: str) -> str:
        """Common input of a stage's chunks."""
        return f"{self.prefix}job:{job_id}:parts:{stage}:input"

    def time_slices(self, job_id: str) -> str:
        """Set of the ids of the queued and running time slices of a job, or matches of a batch."""
        return f"{self.prefix}job:{job_id}:turns"

    def job_arrays(self, job_id: str) -> str:
        """Result of a job as arrays, a reference to npz."""
        return f"{self.prefix}job:{job_id}:arrays"

    def job_summary(self, job_id: str) -> str:
        """Result of a match in brief, JSON."""
        return f"{self.prefix}job:{job_id}:summary"

    def idempotency_record(self, name: str) -> str:
        """Digest of a request with an idempotency key, and its job's id."""
        return f"{self.prefix}order:{name}"

    def queued_by(self, caller: str | None) -> str:
        """Sorted set of the ids of the jobs that a caller has queued, by time of admission."""
        return f"{self.prefix}queued:{caller or ''}"

    def validations_by(self, caller: str | None) -> str:
        """Sorted set of the ids of the validations that a caller has queued, by admission."""
        return f"{self.prefix}validations:{caller or ''}"

    def counted(self, record: JobRecord) -> tuple[str, str]:
        """Sets in which a job counts towards the limits of its caller and of the tenant."""
        if record.is_upload:
            return self.validations_by(record.caller), self.validating
        return self.queued_by(record.caller), self.admitted

    def jobs_in(self, state: str) -> str:
        """Sorted set of the listed jobs' ids in one state, by time of creation."""
        return f"{self.prefix}jobs:{state}"

    def jobs_of(self, name: str) -> str:
        """Sorted set of the listed jobs of a shape or a prototype, by time of creation."""
        return f"{self.prefix}jobs:of:{name}"

    def cached_of(self, name: str) -> str:
        """Set of the names of a shape's or prototype's cached blobs that this tenant has used."""
        return f"{self.prefix}cached:{name}"

    def spectrum_job(self, spectrum: object) -> str:
        """Id of the job that was queued to compute a spectrum."""
        return f"{self.prefix}spectrum:{spectrum}:job"

    @staticmethod
    def spectrum_lock(spectrum: object) -> str:
        """Lock of the process that computes a spectrum."""
        return f"{PREFIX}spectrum:{spectrum}:lock"

    @staticmethod
    def periodic(task: str) -> str:
        """Exists while no process need begin a periodic task again."""
        return f"{PREFIX}periodic:{task}"

    @staticmethod
    def cached_spectrum(spectrum: object) -> str:
        """A cached spectrum, npz; in the cache's own Redis where there is one."""
        return f"{PREFIX}cache:spectrum:{spectrum}"


DEFAULT_KEYS: Final = Keys()
"""The keys of the default tenant."""
