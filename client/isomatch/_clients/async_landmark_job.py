"""Landmarks on their way to a specimen, for the asynchronous client."""

from collections.abc import Sequence

from isomatch._http import AsyncTransport
from isomatch._landmarks import CarriedLandmarks, LandmarkTemplate
from isomatch._models import JobRecord, Shape
from isomatch._operations import landmarks


class AsyncLandmarkJob:
    """The matches of one or several templates with a specimen.

    Attributes
    ----------
    job_ids
        Ids of the matches, in the order of the templates.
    """

    def __init__(
        self,
        transport: AsyncTransport,
        templates: Sequence[LandmarkTemplate],
        specimen: Shape | str,
        records: Sequence[JobRecord],
    ) -> None:
        self._transport = transport
        self._templates = tuple(templates)
        self._specimen = specimen
        self._transfers: dict[str, str] = {}
        self.job_ids = tuple(record.id for record in records)

    async def result(
        self, *, progress: bool = False, timeout: float | None = None
    ) -> CarriedLandmarks:
        """Wait until the matches have ended, and carry the landmarks to the specimen.

        Parameters
        ----------
        progress
            Show a progress bar for each match and transfer on the standard error.
        timeout
            Seconds to wait for each match, and for each transfer along one; None for no limit.

        Raises
        ------
        JobFailed, JobCancelled
            A match or a transfer failed or was cancelled.
        WaitTimeout
            A match or a transfer did not end within `timeout` seconds; it continues.
        WrongCoordinates
            Landmarks of a template are in another coordinate system (LPS or RAS) or unit of length
            than their mesh.
        ValueError
            The templates do not have the same landmarks, or `timeout` is negative.
        TypeError
            `timeout` is no number.
        """
        return await self._transport.run(
            landmarks.get_landmarks(
                self._templates, self._specimen, self.job_ids, self._transfers, progress, timeout
            )
        )

    async def cancel(self) -> None:
        """Cancel the matches and transfers that are queued or running."""
        jobs = (*self.job_ids, *self._transfers.values())
        await self._transport.run(landmarks.cancel_landmarks(jobs))
