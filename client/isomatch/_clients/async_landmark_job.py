"""Landmarks on their way to a specimen, for the asynchronous client."""

from collections.abc import Sequence

from isomatch._clients.documented_as import documented_as
from isomatch._clients.landmark_job import LandmarkJob
from isomatch._http import AsyncTransport
from isomatch._landmarks import CarriedLandmarks, LandmarkTemplate, Placements
from isomatch._models import JobRecord, Shape
from isomatch._operations import landmarks


class AsyncLandmarkJob:
    """The methods are those of :class:`isomatch.LandmarkJob`, awaited."""

    def __init__(
        self,
        transport: AsyncTransport,
        templates: Sequence[LandmarkTemplate],
        specimen: Shape | str,
        records: Sequence[JobRecord],
        placed: Placements,
    ) -> None:
        self._transport = transport
        self._templates = tuple(templates)
        self._specimen = specimen
        self._placed = placed
        self.job_ids = tuple(record.id for record in records)

    @documented_as(LandmarkJob.result)
    async def result(
        self, progress: bool = False, timeout: float | None = None
    ) -> CarriedLandmarks:
        return await self._transport.run(
            landmarks.get_landmarks(
                self._templates, self._specimen, self.job_ids, self._placed, progress, timeout
            )
        )

    @documented_as(LandmarkJob.cancel)
    async def cancel(self) -> None:
        await self._transport.run(landmarks.cancel_landmarks(self.job_ids))
