"""The asynchronous client."""

import os
from collections.abc import AsyncIterator, Iterable, Sequence
from types import TracebackType
from typing import SupportsIndex, Unpack

import httpx2

from isomatch._clients.async_job import AsyncJob
from isomatch._clients.async_landmark_job import AsyncLandmarkJob
from isomatch._clients.recorded_job import RecordedJob
from isomatch._http import (
    AsyncTransport,
    Operation,
    api_key_or_default,
    delete,
    fetch,
    fetch_bytes,
    retries_given,
    timeout_given,
    url_or_default,
)
from isomatch._landmarks import LandmarkSet, LandmarkTemplate
from isomatch._models import (
    Attributes,
    DissimilarityParameters,
    JobRecord,
    JobState,
    MatchParameters,
    Page,
    PrototypeParameters,
    Shape,
    Structures,
)
from isomatch._operations import (
    batches,
    jobs,
    landmarks,
    prototypes,
    registrations,
    transfers,
)
from isomatch._operations.listings import list_all
from isomatch._operations.request_parts import id_of, job_id_of, path_to
from isomatch._operations.shapes import get_geometry
from isomatch._operations.transfers import AttributesSource, Landmark
from isomatch._operations.uploads import UPLOAD_TIMEOUT, upload
from isomatch._results import (
    Batch,
    ConsistentMaps,
    Direction,
    Dissimilarities,
    Element,
    Geometry,
    LearnedPrototype,
    Match,
    Prototype,
    PrototypePoints,
    Registration,
    Result,
    Transfer,
    TransferKind,
)
from isomatch._upload import FileSource, MeshSource, attribute_file, mesh_file, prototype_file
from isomatch._webhooks import Webhook


class AsyncClient:
    """A connection to an isomatch service for asyncio and trio; safe to share between tasks.

    Use it as a context manager, or call :meth:`close`. Every method raises
    :class:`~isomatch.ConnectionFailed` if the service cannot be reached after all retries, and
    :class:`~isomatch.ProblemError` if the service refuses.

    A cancelled task closes its connection; jobs on the service continue until they are cancelled
    themselves.

    Parameters
    ----------
    base_url
        Address of the service; by default the environment variable ``ISOMATCH_URL``, or else
        ``http://127.0.0.1:8000``.
    api_key
        API key, for services that require one; by default the environment variable
        ``ISOMATCH_API_KEY``.
    timeout
        Seconds without progress after which a request fails; None for no limit.
    retries
        Greatest number of repetitions of a request when the connection fails or the service is
        busy (429, 502, 503, 504): after its ``Retry-After``, up to 30 s, or after growing pauses.
        A repeated request never creates a second job. Waiting for a job outlasts a service that
        is away for up to 60 s, unless this is 0.
    transport
        ``httpx2`` transport to use instead of the network.

    Raises
    ------
    ValueError
        `base_url` is not an http(s) address, `api_key` is not printable ASCII, `timeout` is not
        over 0, or `retries` is negative.
    TypeError
        An argument has the wrong type; the message names it.

    Examples
    --------
    >>> async with AsyncClient() as client:
    ...     cat = await client.upload("cat.off")
    ...     lion = await client.upload("lion.off")
    ...     job = await client.match(cat, lion, points=32)
    ...     match = await job.result(progress=True)
    """

    def __init__(
        self,
        base_url: str | None = None,
        *,
        api_key: str | None = None,
        timeout: float | None = 60.0,
        retries: int = 3,
        transport: httpx2.AsyncBaseTransport | None = None,
    ) -> None:
        self.base_url = url_or_default(base_url)
        self._transport = AsyncTransport(
            self.base_url,
            timeout_given(timeout),
            retries_given(retries),
            transport,
            api_key_or_default(api_key),
        )

    async def __aenter__(self) -> "AsyncClient":
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        await self.close()

    def __repr__(self) -> str:
        return f"<AsyncClient {self.base_url}>"

    async def close(self) -> None:
        """Close the connections; the client cannot be used afterwards."""
        await self._transport.close()

    async def _started(self, start: Operation[JobRecord]) -> AsyncJob:
        return AsyncJob(self._transport, await self._transport.run(start))

    async def upload(
        self,
        shape: MeshSource,
        name: str | None = None,
        *,
        file_type: str | None = None,
        timeout: float | None = UPLOAD_TIMEOUT,
    ) -> Shape:
        """Upload a shape. The same file uploaded again has the same id.

        Parameters
        ----------
        shape
            A path; the bytes of a file; an open binary file, read from its beginning; a tuple of
            arrays, vertices (V, 3), faces (F, 3) counted from 0 and optionally colours; an array of
            points, (V, 3), or (V, 6) with normals of length 1; a tuple of points, None and colours;
            or an object with ``.vertices`` and ``.faces`` or ``.triangles``, such as a
            ``trimesh.Trimesh``, a mesh of open3d or a :class:`Geometry`, with its vertex colours.
        name
            Name of the shape; by default that of the file.
        file_type
            Format (off, obj, ply, stl, glb, gltf, zip; of points ply, las, laz, xyz, txt, csv); by
            default the extension of the file.
        timeout
            Seconds the upload may take, until the service has read it; None for no limit.

        Raises
        ------
        UnprocessableShape
            The file is not a usable mesh; the message gives the reason.
        TooLarge
            The file exceeds the service's limit.
        UnsupportedFormat
            The service does not read this format.
        WaitTimeout
            The service did not read the file in time.
        OSError, TypeError, ValueError
            `shape` is none of the above, or cannot be read.
        """
        return await self._transport.run(
            upload(Shape, "/v1/shapes", mesh_file(shape, file_type), name, timeout)
        )

    async def shape(self, shape_id: str) -> Shape:
        """Return a shape by its id.

        Raises
        ------
        NotFound
            There is no shape with this id.
        """
        return await self._transport.run(fetch(Shape, path_to("shapes", shape_id)))

    def shapes(self) -> AsyncIterator[Shape]:
        """Iterate over all shapes, newest first."""
        return self._transport.stream(
            list_all(Page[Shape], "/v1/shapes", self._transport.retries, {})
        )

    async def mesh(self, shape: Shape | str) -> bytes:
        """Return the file of a shape as it was uploaded.

        Raises
        ------
        NotFound
            The id is unknown.
        """
        return await self._transport.run(fetch_bytes(path_to("shapes", shape, "mesh")))

    async def geometry(self, shape: Shape | str) -> Geometry:
        """Return the surface of a shape as arrays.

        Raises
        ------
        NotFound
            The id is unknown.
        """
        return await self._transport.run(get_geometry(shape))

    async def delete_shape(self, shape: Shape | str) -> None:
        """Delete a shape.

        Raises
        ------
        NotFound
            The id is unknown.
        """
        await self._transport.run(delete(path_to("shapes", shape)))

    async def structures(self) -> Structures:
        """Return the metrics and descriptors of the service, and their parameters."""
        return await self._transport.run(fetch(Structures, "/v1/structures"))

    async def match(
        self,
        source: Shape | Prototype | str,
        target: Shape | str,
        *,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[MatchParameters],
    ) -> AsyncJob[Match]:
        """Start a match of two shapes, or of a prototype and a shape.

        Parameters
        ----------
        source, target
            The shapes or their ids. The source may be a :class:`~isomatch.Prototype` or its id,
            whose points are matched by likelihood with the structures it was learned with.
        webhook
            Receiver of a notification when the job has ended: ``{"url": ..., "secret": ...}``.
        idempotency_key
            Key of this request: the service answers later requests with the same key, also from
            other processes, with the same job. Printable ASCII, 1 to 255 characters. By default
            every call starts a job.
        **parameters
            See :class:`~isomatch.MatchParameters`.

        Returns
        -------
        job
            ``job.result()`` waits for the :class:`~isomatch.Match`.

        Raises
        ------
        UnknownShape, UnknownPrototype
            The shape or prototype does not exist; the message names it.
        InvalidRequest
            The value of a parameter is invalid; the message names it.
        TypeError
            A parameter does not exist.
        ValueError
            The name of a file was given, not its shape, or `idempotency_key` or a number cannot be
            sent.
        """
        start = jobs.start_match(
            source, target, parameters=parameters, webhook=webhook, key=idempotency_key
        )
        return await self._started(start)

    async def match_many(
        self,
        source: Shape | Prototype | str,
        targets: Iterable[Shape | str],
        *,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[MatchParameters],
    ) -> AsyncJob[Batch]:
        """Start the matches of one source with many targets, as one job: a batch.

        A match that fails does not end the batch. To cancel the batch cancels its matches;
        one of them is cancelled alone by its own job.

        Parameters
        ----------
        source
            A shape, a :class:`~isomatch.Prototype`, or the id of either.
        targets
            The shapes, or their ids.
        webhook
            Receiver of a notification when all matches have ended.
        idempotency_key
            As for :meth:`match`.
        **parameters
            Of all matches, see :class:`~isomatch.MatchParameters`.

        Returns
        -------
        job
            ``job.ended_matches()`` yields the job of each match as it ends, ``job.matches()``
            returns what is known now, and ``job.result()`` waits for the :class:`~isomatch.Batch`.

        Raises
        ------
        UnknownShape, UnknownPrototype
            A shape or the prototype does not exist; the message names it.
        InvalidRequest
            The value of a parameter is invalid; the message names it.
        TypeError
            A parameter does not exist.
        """
        start = batches.start_batch(
            source, targets, parameters=parameters, webhook=webhook, key=idempotency_key
        )
        return await self._started(start)

    async def upload_attributes(
        self,
        values: AttributesSource,
        name: str | None = None,
        *,
        file_type: str | None = None,
        timeout: float | None = UPLOAD_TIMEOUT,
    ) -> Attributes:
        """Upload attributes of the vertices or faces of a shape. The same file has the same id.

        Parameters
        ----------
        values
            A path, the bytes of a file, or an open binary file: NPZ, CSV, PLY, OBJ or GLB, or text
            of one label a line (.seg, .txt); or arrays by name. Row i is vertex i, or face i, of
            the shape's file.
        name
            Name of the file; by default its own.
        file_type
            Format (npz, csv, ply, obj, glb, seg, txt); by default the extension of the file.
        timeout
            Seconds the upload may take, until the service has read it; None for no limit.

        Raises
        ------
        UnprocessableAttributes
            The file is not a usable file of attributes; the message gives the reason.
        TooLarge
            The file exceeds the service's limit.
        UnsupportedFormat
            The service does not read this format.
        WaitTimeout
            The service did not read the file in time.
        OSError, TypeError, ValueError
            `values` cannot be read.
        """
        return await self._transport.run(
            upload(Attributes, "/v1/attributes", attribute_file(values, file_type), name, timeout)
        )

    async def delete_attributes(self, attributes: Attributes | str) -> None:
        """Delete a file of attributes.

        Raises
        ------
        NotFound
            The id is unknown.
        """
        await self._transport.run(delete(path_to("attributes", attributes)))

    async def transfer(
        self,
        match: RecordedJob | Match | str,
        values: Attributes | AttributesSource | None = None,
        *,
        what: TransferKind,
        direction: Direction = "source_to_target",
        on: Element | None = None,
        names: Iterable[str] = (),
        influences: int | None = None,
        points: Iterable[Landmark] = (),
        landmarks: LandmarkSet | None = None,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncJob[Transfer]:
        """Start to carry a file of attributes, or landmarks, along a match with ``dense=True``.

        Arrays of vertices are carried without the service, too: :meth:`isomatch.Match.transfer`.

        Parameters
        ----------
        match
            The job of the match, its id, or its result.
        values
            Attributes of the vertices or faces of the shape that they are carried from: a file or
            arrays by name, uploaded as by :meth:`upload_attributes`, or an uploaded file. By
            default those in the file of that shape itself, whose colours include its texture.
        what
            ``"scalars"``, ``"vectors"``, ``"colors"``, ``"labels"``, ``"skinning"`` or
            ``"landmarks"``, see :meth:`isomatch.Match.transfer`; ``"texture"``, that of the shape's
            own file, as colours of vertices, and in a GLB file as an image; or ``"uv"``, its
            texture coordinates, in GLB with its images, and in OBJ.
        direction
            ``"source_to_target"`` or ``"target_to_source"``.
        on
            ``"vertices"`` or ``"faces"``: what of the other shape takes the values; None for what
            they are of.
        names
            Attributes to carry, or joints of skinning weights; all by default.
        influences
            For skinning, how many joints each vertex keeps; None for all.
        points
            The landmarks: vertices, or points with `vertices` and `weights`.
        landmarks
            The landmarks by their positions, in the coordinates of the shape's file, instead of
            `points`. Those farther than 0.05 √area from its surface are left out.
        webhook, idempotency_key
            As for :meth:`match`.

        Returns
        -------
        job
            ``job.result()`` waits for the :class:`~isomatch.Transfer`; ``job.save(path)`` writes
            the values to an NPZ, CSV, PLY, OBJ or GLB file.

        Raises
        ------
        NotFound, Gone, Conflict
            There is no such match, it has expired, or has no result (yet).
        UnknownAttributes, UnprocessableAttributes, InvalidRequest
            The values do not exist, cannot be read, or do not fit; the message says why.
        TypeError
            A landmark is neither a vertex nor a point.
        """
        start = transfers.start_transfer(
            match,
            values,
            what=what,
            direction=direction,
            on=on,
            names=names,
            influences=influences,
            points=points,
            landmarks=landmarks,
            webhook=webhook,
            key=idempotency_key,
        )
        return await self._started(start)

    async def landmarks(
        self,
        templates: Sequence[LandmarkTemplate],
        specimen: Shape | str,
        **parameters: Unpack[MatchParameters],
    ) -> AsyncLandmarkJob:
        """Start to carry landmarks from one or several templates to a specimen.

        Each template is matched densely with the specimen, at full resolution. If one match cannot
        be started, or this is interrupted, the others are cancelled.

        Parameters
        ----------
        templates
            Shapes with their landmarks, which have the same labels.
        specimen
            The shape that gets the landmarks, or its id.
        **parameters
            Of the matches, see :class:`~isomatch.MatchParameters`; all but `dense`, `simplify`,
            `landmarks`, `occlusion_cost` and `refine`.

        Returns
        -------
        job
            ``job.result()`` waits for the :class:`~isomatch.CarriedLandmarks`.

        Raises
        ------
        UnknownShape
            A shape does not exist; the message names it.
        InvalidRequest
            The value of a parameter is invalid; the message names it.
        TypeError
            A parameter does not exist.
        ValueError
            There is no template.

        Examples
        --------
        >>> (given,) = read_landmarks("template.mrk.json")
        >>> template = LandmarkTemplate(await client.upload("template.ply"), given)
        >>> job = await client.landmarks([template], await client.upload("a.ply"))
        >>> found = await job.result(progress=True)
        >>> write_landmarks("a.mrk.json", [found.landmark_set("a")])
        """
        keys: list[str] = []
        try:
            start = landmarks.start_landmarks(templates, specimen, parameters, keys)
            records = await self._transport.run(start)
        except BaseException:
            await self._transport.run_shielded(
                landmarks.withdraw_landmarks(templates, specimen, parameters, keys)
            )
            raise
        return AsyncLandmarkJob(self._transport, templates, specimen, records)

    async def register(
        self,
        template: Shape | str,
        shapes: Iterable[Shape | str],
        *,
        scale: bool = False,
        largest_component: bool = False,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncJob[Registration]:
        """Start to register a template to specimens, which then have common vertices.

        Parameters
        ----------
        template
            The shape whose vertices and triangles are put on the surface of each specimen.
        shapes
            The specimens, each once.
        scale
            Scale the specimens to a common size before their mean is taken.
        largest_component
            Take the largest component of a shape that has several. Such a specimen is not
            registered otherwise.
        webhook, idempotency_key
            As for :meth:`match`.

        Returns
        -------
        job
            ``job.result()`` waits for the :class:`~isomatch.Registration`, with positions, mean
            shape and principal components as arrays; ``job.save_registered(path, specimen)`` writes
            one registered template.

        Raises
        ------
        UnknownShape
            A shape does not exist; the message names it.
        InvalidRequest
            The template cannot be registered; the message says why.

        Examples
        --------
        >>> job = await client.register(template, specimens)
        >>> found = await job.result(progress=True)
        >>> found.positions.shape  # (specimens, vertices of the template, 3)
        >>> found.save_meshes("out")
        """
        start = registrations.start_registration(
            template,
            shapes,
            scale=scale,
            largest_component=largest_component,
            webhook=webhook,
            key=idempotency_key,
        )
        return await self._started(start)

    async def consistent_maps(
        self,
        shapes: Iterable[Shape | str],
        *,
        largest_component: bool = False,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
    ) -> AsyncJob[ConsistentMaps]:
        """Start to map all shapes of a collection to one another, consistently.

        Parameters
        ----------
        shapes
            2 to 16 different shapes, or their ids; maps improve one another from three on.
        largest_component
            Take the largest component of a shape that has several. Such a shape is not mapped
            otherwise.
        webhook, idempotency_key
            As for :meth:`match`.

        Returns
        -------
        job
            ``job.result()`` waits for the :class:`~isomatch.ConsistentMaps`.

        Raises
        ------
        UnknownShape
            A shape does not exist; the message names it.
        InvalidRequest
            The shapes cannot be mapped; the message says why.

        Examples
        --------
        >>> job = await client.consistent_maps(shapes)
        >>> found = await job.result(progress=True)
        >>> found.map(0, 2)  # vertices of the third shape, a row for each vertex of the first
        >>> [shape.name for shape in found.shapes if not shape.fits]
        """
        start = jobs.start_consistent_maps(
            shapes, largest_component=largest_component, webhook=webhook, key=idempotency_key
        )
        return await self._started(start)

    async def dissimilarities(
        self,
        shapes: Iterable[Shape | str],
        labels: Iterable[str] | None = None,
        *,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[DissimilarityParameters],
    ) -> AsyncJob[Dissimilarities]:
        """Start the comparison of all pairs of a collection of shapes.

        Parameters
        ----------
        shapes
            Two or more different shapes, or their ids.
        labels
            Class of each shape, for retrieval scores and the order of the heat map.
        webhook, idempotency_key
            As for :meth:`match`.
        **parameters
            See :class:`~isomatch.DissimilarityParameters`.

        Returns
        -------
        job
            ``job.result()`` waits for the :class:`~isomatch.Dissimilarities`; ``job.partial()``
            returns those computed so far.

        Raises
        ------
        UnknownShape
            A shape does not exist; the message names it.
        InvalidRequest
            A shape cannot be compared, or the value of a parameter is invalid; the message names
            it.
        TypeError
            A parameter does not exist.
        """
        start = jobs.start_dissimilarities(
            shapes, labels, parameters=parameters, webhook=webhook, key=idempotency_key
        )
        return await self._started(start)

    async def learn_prototype(
        self,
        shapes: Iterable[Shape | str],
        correspondences: Iterable[Iterable[SupportsIndex]] | None = None,
        *,
        name: str | None = None,
        reference: Shape | str | None = None,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[PrototypeParameters],
    ) -> AsyncJob[LearnedPrototype]:
        """Start to learn a prototype of a class of shapes from examples.

        Parameters
        ----------
        shapes
            Two or more different examples, or their ids.
        correspondences
            Corresponding vertices of the M files, (M, n); by default they are found by the method
            of the parameter `correspondence`.
        name
            Name of the prototype, by default ``"prototype"``; a name that exists gets its next
            version.
        reference
            The example on which the points are sampled; by default the first.
        webhook, idempotency_key
            As for :meth:`match`.
        **parameters
            See :class:`~isomatch.PrototypeParameters`.

        Returns
        -------
        job
            ``job.result()`` waits for the :class:`~isomatch.LearnedPrototype`, whose `prototype` is
            the :class:`~isomatch.Prototype`.

        Raises
        ------
        UnknownShape
            A shape does not exist; the message names it.
        InvalidRequest
            A shape cannot be an example, or the value of a parameter is invalid; the message
            names it.
        TypeError
            A parameter does not exist.
        """
        start = prototypes.start_prototype(
            shapes,
            correspondences,
            name=name,
            reference=reference,
            parameters=parameters,
            webhook=webhook,
            key=idempotency_key,
        )
        return await self._started(start)

    async def prototype(self, prototype_id: str) -> Prototype:
        """Return a prototype by its id.

        Raises
        ------
        NotFound
            There is no prototype with this id.
        """
        return await self._transport.run(fetch(Prototype, path_to("prototypes", prototype_id)))

    def prototypes(self, name: str | None = None) -> AsyncIterator[Prototype]:
        """Iterate over all prototypes, or the versions of one name, newest first."""
        return self._transport.stream(
            list_all(Page[Prototype], "/v1/prototypes", self._transport.retries, {"name": name})
        )

    async def download_prototype(
        self, prototype: Prototype | str, path: str | os.PathLike[str]
    ) -> None:
        """Write a prototype to a NumPy file, ``.npz``.

        Raises
        ------
        NotFound
            The id is unknown.
        OSError
            The file cannot be written.
        """
        await self._transport.run(prototypes.download_prototype(prototype, path))

    async def prototype_points(self, prototype: Prototype | str) -> PrototypePoints:
        """Return the points of a prototype and their distances.

        Raises
        ------
        NotFound
            The id is unknown.
        """
        return await self._transport.run(prototypes.get_prototype_points(prototype))

    async def upload_prototype(
        self,
        archive: FileSource,
        name: str | None = None,
        *,
        timeout: float | None = UPLOAD_TIMEOUT,
    ) -> Prototype:
        """Upload a prototype. The same file uploaded again has the same id.

        Parameters
        ----------
        archive
            File of :meth:`download_prototype`: its path, its bytes, or the open file.
        name
            Name of the prototype; by default that of the file.
        timeout
            Seconds the upload may take, until the service has read it; None for no limit.

        Raises
        ------
        UnprocessablePrototype
            The file is not a prototype; the message gives the reason.
        TooLarge
            The file exceeds the service's limit.
        WaitTimeout
            The service did not read the file in time.
        OSError, TypeError
            `archive` cannot be read.
        """
        return await self._transport.run(
            upload(Prototype, "/v1/prototype-archives", prototype_file(archive), name, timeout)
        )

    async def delete_prototype(self, prototype: Prototype | str) -> None:
        """Delete a prototype.

        Raises
        ------
        NotFound
            The id is unknown.
        """
        await self._transport.run(delete(path_to("prototypes", prototype)))

    async def job(self, job_id: Result | str) -> AsyncJob:
        """Return a job by its id, or the job of a result.

        Raises
        ------
        NotFound
            There is no job with this id.
        ValueError
            The result is of an earlier version, which does not name its job.
        """
        record = await self._transport.run(jobs.get_job(job_id_of(job_id)))
        return AsyncJob(self._transport, record)

    def jobs(
        self,
        state: JobState | None = None,
        *,
        kind: str | None = None,
        of: str | Shape | Prototype | None = None,
    ) -> AsyncIterator[AsyncJob]:
        """Iterate over all jobs, newest first.

        Parameters
        ----------
        state
            Only those in this state: ``"queued"``, ``"running"``, ``"succeeded"``, ``"failed"``
            or ``"cancelled"``.
        kind
            Only those of this kind: ``"match"``, ``"batch"``, ``"dissimilarities"``,
            ``"prototype"``, ``"transfer"``, ``"registration"`` or ``"consistent_maps"``. The
            matches of a batch are not among them.
        of
            Only those of this shape or prototype.
        """
        query = {"state": state, "kind": kind, "shape": None if of is None else id_of(of)}
        records = self._transport.stream(
            list_all(Page[JobRecord], "/v1/jobs", self._transport.retries, query)
        )
        return (AsyncJob(self._transport, record) async for record in records)
