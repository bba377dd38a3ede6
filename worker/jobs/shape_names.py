"""Names of the shapes of a job: those of its request, or else those they are stored under."""

from collections.abc import Sequence

from broker.store import Store


def shape_names(
    shapes: Sequence[str], given: Sequence[str | None] | None, store: Store
) -> list[str | None]:
    """Return a name for each shape, None where no name is known.

    Parameters
    ----------
    shapes
        Ids of the shapes.
    given
        Names of the request, in their order; None for those that it left out. The same bytes
        uploaded under two names are one shape, which is stored under the first.
    store
        The store that keeps the shapes.
    """
    return [
        name or (None if record is None else record.name)
        for name, record in zip(
            given or (None,) * len(shapes), store.shapes.records(shapes), strict=True
        )
    ]
