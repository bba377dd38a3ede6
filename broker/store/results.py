"""Results of jobs: document, arrays, summary, pictures and other formats."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import BinaryIO, Final, cast

from pydantic import TypeAdapter

from broker.blobs import BlobLost
from broker.contracts import PicturePayload, Summary
from broker.store.quotas import Quotas
from broker.store.replies import text
from broker.store.tenant_data import TenantData

_SUMMARY: Final[TypeAdapter[Summary]] = TypeAdapter(Summary)


@dataclass(frozen=True)
class Results(TenantData):
    """The stored results; :meth:`broker.store.Jobs.succeed` stores all but pictures.

    Summaries are short, and read many at a time: they are in Redis.
    """

    def document(self, job_id: str) -> bytes | None:
        """Return the result of a job, JSON in gzip."""
        return self.blobs.get(self.keys.job_result(job_id))

    def open_document(self, job_id: str) -> BinaryIO | None:
        """Return the result of a job, JSON in gzip, as a file."""
        return self.blobs.open(self.keys.job_result(job_id))

    def kept(self, job_ids: Sequence[str]) -> set[str]:
        """Return those of some jobs whose results are still kept."""
        with self.client.pipeline(transaction=False) as pipe:
            for job_id in job_ids:
                pipe.exists(self.keys.job_result(job_id))
            return {one for one, kept in zip(job_ids, pipe.execute(), strict=True) if kept}

    def is_whole(self, job_id: str) -> bool:
        """Return whether a result is kept, without reading it.

        Raises
        ------
        BlobLost
            Its bytes are missing, or fewer or more.
        BlobsAway, NotMigrated
            As for all that reads it.
        """
        key = self.keys.job_result(job_id)
        if self.blobs.reference(key) is None:
            return False
        if self.blobs.lost([key]):
            raise BlobLost(key, "missing or damaged")
        return True

    def arrays(self, job_id: str) -> bytes | None:
        """Return the result of a job as arrays, npz."""
        return self.blobs.get(self.keys.job_arrays(job_id))

    def open_arrays(self, job_id: str) -> BinaryIO | None:
        """Return the result of a job as arrays, npz, in a file."""
        return self.blobs.open(self.keys.job_arrays(job_id))

    def delete(self, *job_ids: str) -> bool:
        """Delete the results of jobs, with arrays and pictures; False if there was none.

        Pictures that an earlier version has made are not known; they are not returned any more, and
        expire when the result would have.
        """
        self.client.delete(*map(self.keys.job_summary, job_ids))
        # Not `any` of a generator, which would end with the first result.
        found = [
            self._delete([self.keys.job_result(one), self.keys.job_arrays(one)]) for one in job_ids
        ]
        # Pictures last: without the result, none that is stored from now on is kept.
        known = list(map(self.keys.job_pictures, job_ids))
        with self.client.pipeline(transaction=False) as pipe:
            for key in known:
                pipe.smembers(key)
            pipe.delete(*known)
            *pictures, _ = pipe.execute()
        found += [self._delete([text(one) for one in made]) for made in pictures if made]
        return any(found)

    def _delete(self, names: Sequence[str]) -> bool:
        with self.client.pipeline() as pipe:
            for name in names:
                self.blobs.look_up(name, pipe)
            self.blobs.unlink(names, pipe)
            replies = pipe.execute(raise_on_error=False)
        stored = replies[: len(names)]
        self.blobs.discard(zip(names, stored, strict=True))
        return any(reply is not None for reply in stored)

    def summaries(self, job_ids: Sequence[str]) -> list[Summary | None]:
        """Return results in brief; None for those that have none, or none any more."""
        keys = [self.keys.job_summary(one) for one in job_ids]
        found = cast(list[bytes | None], self.client.mget(keys) if keys else [])
        return [None if one is None else _SUMMARY.validate_json(one) for one in found]

    def picture(self, payload: PicturePayload) -> bytes | None:
        """Return a picture of a result that is kept, or the result in another format."""
        if not self.kept([payload.job]):
            return None
        return self.blobs.get(self.keys.job_picture(payload.job, payload.variant))

    def open_picture(self, payload: PicturePayload) -> BinaryIO | None:
        """Return a picture of a result that is kept, or it in another format, as a file."""
        if not self.kept([payload.job]):
            return None
        return self.blobs.open(self.keys.job_picture(payload.job, payload.variant))

    def set_picture(self, payload: PicturePayload, picture: bytes) -> None:
        """Store a picture for as long as the result itself, unless that is gone.

        Raises
        ------
        QuotaExceeded
            The tenant has as many bytes as it may have.
        """
        result = self.keys.job_result(payload.job)
        left = self.client.ttl(result)
        if left > 0:
            key = self.keys.job_picture(payload.job, payload.variant)
            self._part(Quotas).check(len(picture))
            pictures = self.keys.job_pictures(payload.job)
            with self.client.pipeline() as pipe:
                # Before there is one, so that there is none that is not found.
                pipe.sadd(pictures, key)
                pipe.expire(pictures, left)
                pipe.execute()
            self.blobs.save(key, picture, left)
            # If the result was deleted meanwhile, this picture may not have been found.
            if not self.client.exists(result):
                self._delete([key])
