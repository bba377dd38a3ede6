"""Progress bars of jobs."""

from types import TracebackType
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

from isomatch._models import JobRecord


class ProgressBar:
    """A progress bar on a terminal or in a notebook; elsewhere one line for each stage.

    Parameters
    ----------
    file
        Output; None for the standard error.
    """

    def __init__(self, file: TextIO | None = None) -> None:
        self._console = Console(file=file, stderr=file is None)
        self._drawn = self._console.is_terminal or self._console.is_jupyter
        self._stage = ""
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TimeElapsedColumn(),
            console=self._console,
            transient=True,
            disable=not self._drawn,
        )
        self._task = self._bar.add_task("queued", total=1.0)

    def __enter__(self) -> "ProgressBar":
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def update(self, record: JobRecord) -> None:
        """Show the progress of the job."""
        stage = record.progress.stage if record.state == "running" else record.state
        if record.state == "queued" and record.position:
            stage = f"queued, {record.position} jobs ahead"
        fraction = 1.0 if record.state == "succeeded" else record.progress.fraction
        self._bar.update(self._task, description=stage, completed=fraction)
        if not self._drawn and stage != self._stage:
            self._console.print(f"{fraction:4.0%}  {stage}", markup=False, highlight=False)
        self._stage = stage
