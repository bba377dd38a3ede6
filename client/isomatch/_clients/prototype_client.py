"""What a client does with prototypes."""

import os
from collections.abc import Iterable, Iterator
from functools import partial
from typing import Unpack

from isomatch._clients.job import Job
from isomatch._http import BlockingTransport
from isomatch._models import PrototypeParameters, Shape
from isomatch._operations import ArchiveSource, drawing
from isomatch._operations import prototype as operations
from isomatch._results import LearnedPrototype, Prototype, PrototypePoints
from isomatch._webhooks import Webhook


class PrototypeClient:
    """The part of :class:`isomatch.Client` that is about prototypes."""

    _transport: BlockingTransport

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
        return self._transport.run(drawing.get_points(prototype))

    def upload_prototype(
        self, archive: ArchiveSource, name: str | None = None, *, timeout: float | None = 600.0
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
