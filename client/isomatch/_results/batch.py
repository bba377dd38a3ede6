"""Matches of one source with many targets, when all have ended and while they run."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pydantic import FiniteFloat

from isomatch._models import Answer, AnsweredState, MatchParameters, MatchSummary
from isomatch._problem import Problem
from isomatch._results.result_document import Drawable, Result
from isomatch._results.summary import called, screen

if TYPE_CHECKING:
    from plotly.graph_objects import Figure


class BatchMatch(Answer):
    """One match of a batch.

    Attributes
    ----------
    target, target_name
        Id of the target, and its name: that in the request, else the stored one, else None.
    job
        Id of the job of this match:
        ``client.job(match.job).result()`` is the :class:`isomatch.Match`, and
        ``client.job(match.job).cancel()`` cancels this match alone.
    state
        ``"queued"``, ``"running"``, ``"succeeded"``, ``"failed"`` or ``"cancelled"``.
    fraction
        Completed share of the match, 0 to 1.
    error
        Problem that made it fail; None otherwise.
    summary
        The answer in brief; None unless it has succeeded.
    """

    target: str
    target_name: str | None
    job: str
    state: AnsweredState
    fraction: FiniteFloat
    error: Problem | None
    summary: MatchSummary | None

    @property
    def finished(self) -> bool:
        """True if the match has succeeded, failed or been cancelled."""
        return self.state in ("succeeded", "failed", "cancelled")


class Batch(Result):
    """Matches of one source with many targets, all of which have ended.

    Attributes
    ----------
    version
        Version of the result format.
    source, source_name
        Id of the source, a shape or a prototype, and its name: that in the request, else the
        stored one, else None.
    parameters
        Parameters of the matches, with defaults filled in.
    matches
        The matches, in the order of the targets.
    succeeded
        Number of matches that have succeeded.
    warnings
        Remarks of the service on this result.
    timings
        ``"total"``, the elapsed seconds.
    """

    version: int = 1
    source: str
    source_name: str | None
    parameters: MatchParameters
    matches: tuple[BatchMatch, ...]
    succeeded: int
    warnings: tuple[str, ...]
    timings: dict[str, FiniteFloat]

    def __repr__(self) -> str:
        return f"<Batch of {len(self.matches)} matches, {self.succeeded} succeeded>"

    def __str__(self) -> str:
        targets = ((match.target_name, match.target) for match in self.matches)
        source, *names = called([(self.source_name, self.source), *targets])
        heading = f"{source} matched with {self.succeeded} of {len(self.matches)} targets"
        return screen(heading, list(map(_line, self.matches, names)))

    def _figure(self, drawn: Sequence[Drawable], alternative: int | None) -> "Figure":
        raise ValueError("a batch has no picture; draw its matches, as in client.job(id).plot()")


class BatchProgress(Answer):
    """The matches of a batch as they are now.

    Attributes
    ----------
    job, state
        Id and state of the batch.
    source, source_name
        As in :class:`Batch`.
    ended
        Number of matches that have ended.
    matches
        The matches, in the order of the targets.
    """

    job: str
    state: AnsweredState
    source: str
    source_name: str | None
    ended: int
    matches: tuple[BatchMatch, ...]


def _line(match: BatchMatch, name: str) -> str:
    said = f"{name}: {match.state}"
    if match.error is not None:
        return f"{said}: {match.error.summary}"
    if match.summary is None:
        return said
    order = f"second-order distortion {match.summary.distortion.second_order:.3g}"
    sure = "" if match.summary.confidence is None else f", {match.summary.confidence}"
    return f"{said}, {order}{sure}"
