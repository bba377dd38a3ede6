"""The client: the way in."""

import os
from collections.abc import Iterable, Iterator
from functools import partial
from types import TracebackType
from typing import Unpack

import httpx2

from isomatch import _operations as operations
from isomatch._clients.job import Job
from isomatch._http import BlockingTransport, address, key
from isomatch._models import (
    DissimilarityParameters,
    JobState,
    MatchParameters,
    PrototypeParameters,
    Shape,
    Structures,
)
from isomatch._results import (
    Dissimilarities,
    Geometry,
    LearnedPrototype,
    Match,
    Prototype,
    PrototypePoints,
)
from isomatch._upload import MeshSource
from isomatch._webhooks import Webhook


class Client:
    """A connection to an isomatch service; safe to share between threads.

    Use it as a context manager, or call :meth:`close`. Every method raises
    :class:`~isomatch.ConnectionFailed` if the service cannot be reached, after a few attempts
    where repeating does no harm, and :class:`~isomatch.ProblemError` if it refuses.

    Parameters
    ----------
    base_url
        Address of the service; by default that in the environment variable ``ISOMATCH_URL``, or
        else ``http://127.0.0.1:8000``.
    api_key
        Key the service asks for, if it does; by default that in the environment variable
        ``ISOMATCH_API_KEY``.
    timeout
        Seconds without any progress after which a request fails; None for no limit.
    retries
        How often a request is repeated when the connection fails, where that does no harm, or the
        service says that it is busy (429, 503): after as long as it asks for, up to 30 s, or else
        after pauses that grow. Jobs are asked for with a key that keeps them from being made twice.
    transport
        An ``httpx2`` transport to carry the requests instead of the network.

    Raises
    ------
    ValueError
        `base_url` is not an http(s) address, or `api_key` cannot be sent.

    Examples
    --------
    >>> with Client() as client:
    ...     cat = client.upload("cat.off")
    ...     lion = client.upload("lion.off")
    ...     match = client.match(cat, lion, points=32).result(progress=True)
    """

    def __init__(
        self,
        base_url: str | None = None,
        *,
        api_key: str | None = None,
        timeout: float | None = 60.0,
        retries: int = 3,
        transport: httpx2.BaseTransport | None = None,
    ) -> None:
        self.base_url = address(base_url)
        self._transport = BlockingTransport(
            self.base_url, timeout, retries, transport, key(api_key)
        )

    def __enter__(self) -> "Client":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Client {self.base_url}>"

    def close(self) -> None:
        """Close the connections; the client cannot be used any more."""
        self._transport.close()

    def upload(
        self,
        shape: MeshSource,
        name: str | None = None,
        *,
        file_type: str | None = None,
        timeout: float | None = 600.0,
    ) -> Shape:
        """Upload a shape; the same file again costs nothing and has the same id.

        Parameters
        ----------
        shape
            A path; a file's bytes; an open binary file, which is read from its beginning; a
            tuple of arrays, vertices (V, 3) and faces (F, 3) counted from 0; or an object with
            such ``.vertices`` and ``.faces``, like a ``trimesh.Trimesh``, whose vertex colours
            are sent too.
        name
            A name to find it by; by default that of the file.
        file_type
            Format (off, obj, ply, stl, glb, gltf, zip), where no file name tells it.
        timeout
            Seconds the service may take to read the file once it has it; None for no limit.

        Raises
        ------
        UnprocessableShape
            The file is not a usable mesh; the message says why.
        TooLarge
            It is over the service's limit.
        UnsupportedFormat
            It is not of a format the service reads.
        WaitTimeout
            The service has it and has not read it in time.
        OSError, TypeError, ValueError
            `shape` is not readable as one of the above.
        """
        return self._transport.run(operations.upload(shape, name, file_type, timeout))

    def shape(self, shape_id: str) -> Shape:
        """Return one shape.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return self._transport.run(operations.get_shape(shape_id))

    def shapes(self) -> Iterator[Shape]:
        """Go through all shapes, newest first, asking for page after page."""
        return self._transport.pages(operations.list_shapes)

    def mesh(self, shape: Shape | str) -> bytes:
        """Return the mesh file of a shape, given itself or its id, as it was uploaded.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return self._transport.run(operations.get_mesh(shape))

    def geometry(self, shape: Shape | str) -> Geometry:
        """Return the surface of a shape, given itself or its id, as arrays.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return self._transport.run(operations.get_geometry(shape))

    def delete_shape(self, shape: Shape | str) -> None:
        """Delete a shape, given itself or its id.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        self._transport.run(operations.delete_shape(shape))

    def structures(self) -> Structures:
        """Return the metrics and descriptors that can be chosen, and their parameters."""
        return self._transport.run(operations.list_structures())

    def match(
        self,
        source: Shape | Prototype | str,
        target: Shape | str,
        *,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[MatchParameters],
    ) -> Job[Match]:
        """Start to match two shapes, once even if a broken connection has the request repeated.

        Parameters
        ----------
        source, target
            The shapes or their ids. The source may be a :class:`~isomatch.Prototype` or its id:
            then its points are matched by likelihood, with the structures it was learned with.
        webhook
            Whom the service is to tell when the job has ended: ``{"url": ..., "secret": ...}``.
        idempotency_key
            Name of this request: asked again with the same, even by another process, the service
            answers with the job there is; by default each call is a request of its own.
        **parameters
            See :class:`~isomatch.MatchParameters`. Only those that are given are sent.

        Returns
        -------
        job
            ``job.result()`` waits for the :class:`~isomatch.Match`.

        Raises
        ------
        UnknownShape, UnknownPrototype
            There is no such shape, or prototype; the message says which.
        InvalidRequest
            A parameter has a value without meaning; the message says which.
        TypeError
            There is no such parameter.
        """
        start = operations.start_match(source, target, parameters, webhook, idempotency_key)
        return Job(self._transport, self._transport.run(start))

    def dissimilarities(
        self,
        shapes: Iterable[Shape | str],
        labels: Iterable[str] | None = None,
        *,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[DissimilarityParameters],
    ) -> Job[Dissimilarities]:
        """Start to compare all shapes of a collection with one another.

        Parameters
        ----------
        shapes
            The shapes or their ids, two or more, each once.
        labels
            Class of each shape, by which retrieval is scored and the heat map ordered.
        webhook, idempotency_key
            As for :meth:`match`.
        **parameters
            See :class:`~isomatch.DissimilarityParameters`. Only those that are given are sent.

        Returns
        -------
        job
            ``job.result()`` waits for the :class:`~isomatch.Dissimilarities`; ``job.partial()``
            are those that are known already.

        Raises
        ------
        UnknownShape
            There is no such shape; the message says which.
        InvalidRequest
            A shape cannot be compared, or a parameter has a value without meaning; the message
            says which.
        TypeError
            There is no such parameter.
        """
        start = operations.start_dissimilarities(
            shapes, labels, parameters, webhook, idempotency_key
        )
        return Job(self._transport, self._transport.run(start))

    def learn_prototype(
        self,
        shapes: Iterable[Shape | str],
        correspondences: Iterable[Iterable[int]] | None = None,
        *,
        name: str | None = None,
        reference: Shape | str | None = None,
        webhook: Webhook | None = None,
        idempotency_key: str | None = None,
        **parameters: Unpack[PrototypeParameters],
    ) -> Job[LearnedPrototype]:
        """Start to learn a prototype from examples of a class of shapes.

        Parameters
        ----------
        shapes
            The examples or their ids, two or more, each once.
        correspondences
            Corresponding points: for each shape the vertex numbers in its file, an array of shape
            (M, n) or lists of one length; by default they are found as the parameter
            `correspondence` says.
        name
            What to call it, by default ``"prototype"``; another one of a name that there is
            becomes its next version.
        reference
            The example that the points are chosen on; by default the first.
        webhook, idempotency_key
            As for :meth:`match`.
        **parameters
            See :class:`~isomatch.PrototypeParameters`. Only those that are given are sent.

        Returns
        -------
        job
            ``job.result().prototype`` waits for the :class:`~isomatch.Prototype`.

        Raises
        ------
        UnknownShape
            There is no such shape; the message says which.
        InvalidRequest
            A shape cannot be an example, or a parameter has a value without meaning; the message
            says which.
        TypeError
            There is no such parameter.
        """
        start = operations.start_prototype(
            shapes, correspondences, name, reference, parameters, webhook, idempotency_key
        )
        return Job(self._transport, self._transport.run(start))

    def prototype(self, prototype_id: str) -> Prototype:
        """Return one prototype.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return self._transport.run(operations.get_prototype(prototype_id))

    def prototypes(self, name: str | None = None) -> Iterator[Prototype]:
        """Go through all prototypes, or the versions of one name, newest first."""
        return self._transport.pages(partial(operations.list_prototypes, name=name))

    def download_prototype(self, prototype: Prototype | str, path: str | os.PathLike[str]) -> None:
        """Write a prototype, given itself or its id, to a NumPy file, ``.npz``.

        Raises
        ------
        NotFound
            There is none with this id.
        OSError
            The file cannot be written.
        """
        self._transport.run(operations.download_prototype(prototype, path))

    def prototype_points(self, prototype: Prototype | str) -> PrototypePoints:
        """Return the points of a prototype, given itself or its id, and their distances.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return self._transport.run(operations.get_prototype_points(prototype))

    def upload_prototype(
        self,
        archive: operations.ArchiveSource,
        name: str | None = None,
        *,
        timeout: float | None = 600.0,
    ) -> Prototype:
        """Upload a prototype; the same file again is the same prototype.

        Parameters
        ----------
        archive
            What :meth:`download_prototype` wrote: its path, its bytes, or the open file.
        name
            What to call it; by default as the file.
        timeout
            Seconds the service may take to read the file once it has it; None for no limit.

        Raises
        ------
        UnprocessablePrototype
            The file is no prototype; the message says why.
        TooLarge
            It is over the service's limit.
        WaitTimeout
            The service has it and has not read it in time.
        OSError, TypeError
            `archive` is not readable.
        """
        return self._transport.run(operations.upload_prototype(archive, name, timeout))

    def delete_prototype(self, prototype: Prototype | str) -> None:
        """Delete a prototype, given itself or its id.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        self._transport.run(operations.delete_prototype(prototype))

    def job(self, job_id: str) -> Job:
        """Return one job.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return Job(self._transport, self._transport.run(operations.get_job(job_id)))

    def jobs(
        self,
        state: JobState | None = None,
        *,
        kind: str | None = None,
        of: str | Shape | Prototype | None = None,
    ) -> Iterator[Job]:
        """Go through all jobs, newest first.

        Parameters
        ----------
        state
            Only those in this state: ``"queued"``, ``"running"``, ``"succeeded"``, ``"failed"``
            or ``"cancelled"``.
        kind
            Only those of this kind: ``"match"``, ``"dissimilarities"`` or ``"prototype"``.
        of
            Only those of this shape or prototype.
        """
        listing = partial(operations.list_jobs, state=state, kind=kind, of=of)
        records = self._transport.pages(listing)
        return (Job(self._transport, record) for record in records)
