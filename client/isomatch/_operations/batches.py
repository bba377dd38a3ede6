"""Operations that start batches, and look at their matches."""

from collections.abc import Iterable, Iterator

from isomatch._http import Json, Operation
from isomatch._models import JobRecord, MatchParameters, Shape, check_names
from isomatch._operations.jobs import start_job
from isomatch._operations.request_parts import id_of, listed, named, names_of
from isomatch._results import BatchProgress, Prototype
from isomatch._webhooks import Webhook


def start_batch(
    source: Shape | Prototype | str,
    targets: Iterable[Shape | str],
    *,
    parameters: MatchParameters,
    webhook: Webhook | None,
    key: str | None,
) -> Operation[JobRecord]:
    """Queue the matches of one source with many targets."""
    check_names(parameters, MatchParameters.__annotations__, "match_many")
    every = listed(targets, "shapes")
    body: dict[str, Json] = {
        "source": id_of(source),
        "targets": [id_of(one) for one in every],
        "target_names": names_of(every),
        **named(source_name=source),
    }
    return (yield from start_job("/v1/batches", body, parameters, webhook, key))


class EndedMatches:
    """The matches of a batch that have ended, each told once."""

    def __init__(self) -> None:
        self._told: set[str] = set()

    def new(self, progress: BatchProgress) -> Iterator[str]:
        """Yield the ids of the jobs that have ended since this was called before."""
        for one in progress.matches:
            if one.finished and one.job not in self._told:
                self._told.add(one.job)
                yield one.job

    def others(self, progress: BatchProgress) -> list[str]:
        """Return the ids of the jobs that have not been told of."""
        return [one.job for one in progress.matches if one.job not in self._told]
