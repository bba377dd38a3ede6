"""Whether the blob store answers, for Prometheus."""

from collections.abc import Callable
from math import nan

from prometheus_client import CollectorRegistry, Gauge

from broker.blobs import BlobError


class BlobsUp:
    """The gauge of the blob store, set by a task that uses it regularly.

    Parameters
    ----------
    registry
        Registry that it is added to.
    """

    def __init__(self, registry: CollectorRegistry) -> None:
        self._up = Gauge(
            "isomatch_blobs_up",
            "Whether the blob store answers, and is that of this Redis; NaN until it was asked.",
            registry=registry,
        )
        self._up.set(nan)

    def noted(self, task: Callable[[], object]) -> Callable[[], None]:
        """Return a task that sets the gauge by whether the blob store fails it.

        Parameters
        ----------
        task
            A task that uses the blob store.
        """

        def run() -> None:
            try:
                task()
            except BlobError:
                self._up.set(0)
                raise
            self._up.set(1)

        return run
