"""The client: the way in."""

from collections.abc import Iterable, Iterator
from functools import partial
from types import TracebackType
from typing import Unpack

import httpx2

from isomatch._clients.job import Job
from isomatch._clients.prototype_client import PrototypeClient
from isomatch._http import BlockingTransport, address, key
from isomatch._models import DissimilarityParameters, JobState, MatchParameters, Shape, Structures
from isomatch._operations import drawing, id_of
from isomatch._operations import job as job_operations
from isomatch._operations import shape as shape_operations
from isomatch._results import Dissimilarities, Geometry, Match, Prototype
from isomatch._upload import MeshSource
from isomatch._webhooks import Webhook


class Client(PrototypeClient):
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
        return self._transport.run(shape_operations.upload(shape, name, file_type, timeout))

    def shape(self, shape_id: str) -> Shape:
        """Return one shape.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return self._transport.run(shape_operations.get_shape(shape_id))

    def shapes(self) -> Iterator[Shape]:
        """Go through all shapes, newest first, asking for page after page."""
        return self._transport.pages(shape_operations.list_shapes)

    def mesh(self, shape: Shape | str) -> bytes:
        """Return the mesh file of a shape, given itself or its id, as it was uploaded.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return self._transport.run(shape_operations.get_mesh(shape))

    def geometry(self, shape: Shape | str) -> Geometry:
        """Return the surface of a shape, given itself or its id, as arrays.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return self._transport.run(drawing.get_geometry(shape))

    def delete_shape(self, shape: Shape | str) -> None:
        """Delete a shape, given itself or its id.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        self._transport.run(shape_operations.delete_shape(shape))

    def structures(self) -> Structures:
        """Return the metrics and descriptors that can be chosen, and their parameters."""
        return self._transport.run(shape_operations.list_structures())

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
        start = job_operations.start_match(source, target, parameters, webhook, idempotency_key)
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
        start = job_operations.start_dissimilarities(
            shapes, labels, parameters, webhook, idempotency_key
        )
        return Job(self._transport, self._transport.run(start))

    def job(self, job_id: str) -> Job:
        """Return one job.

        Raises
        ------
        NotFound
            There is none with this id.
        """
        return Job(self._transport, self._transport.run(job_operations.get_job(job_id)))

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
        named = None if of is None else id_of(of)
        listing = partial(job_operations.list_jobs, state=state, kind=kind, of=named)
        records = self._transport.pages(listing)
        return (Job(self._transport, record) for record in records)
