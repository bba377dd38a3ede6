"""Jobs that tools wait for: progress is reported, and a cancelled call cancels its job."""

from collections.abc import Awaitable
from typing import Any, Final, TypeVar

import anyio
from mcp.server.mcpserver import Context

from isomatch._clients import AsyncJob
from isomatch._results import Result

CANCELLING: Final = 5.0
"""Seconds that the cancellation of a job may take."""

ResultT = TypeVar("ResultT", bound=Result)


async def finished(
    starting: Awaitable[AsyncJob[ResultT]], context: Context[Any, Any]
) -> tuple[AsyncJob[ResultT], ResultT]:
    """Start a job, report its progress, and return it with its result.

    If the call is cancelled, by the program or because it leaves, the job is cancelled, too.

    Raises
    ------
    JobFailed, JobCancelled
        There is no result.
    """
    # A job whose id did not arrive could not be cancelled.
    with anyio.CancelScope(shield=True):
        job = await starting
    try:
        reported = -1.0
        async for record in job.events():
            # A recovered job begins anew, but progress of a call has to increase.
            if record.progress.fraction > reported:
                reported = record.progress.fraction
                await context.report_progress(reported, 1.0, record.stage)
        return job, await job.result()
    except anyio.get_cancelled_exc_class():
        with anyio.move_on_after(CANCELLING, shield=True):
            await job.cancel()
        raise
