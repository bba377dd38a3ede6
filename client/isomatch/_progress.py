"""Progress bars of jobs."""

import threading
from importlib import import_module
from types import TracebackType
from typing import Final

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

from isomatch._models import JobRecord

ID_SHOWN: Final = 8
"""Characters of a job's id that name its bar."""


class ProgressBar:
    """A progress bar on a terminal or in a notebook; elsewhere one line for each stage.

    In a notebook without ipywidgets there are lines, too, as rich draws nothing there.

    Jobs that are watched at once, in threads or tasks, have a bar each, one below the other.
    """

    def __init__(self) -> None:
        self._console = Console(stderr=True)
        self._drawn = self._console.is_terminal or (self._console.is_jupyter and _has_widgets())
        self._line = ""

    def __enter__(self) -> "ProgressBar":
        if self._drawn:
            self._bars = _display.enter()
            self._task = self._bars.add_task("queued", total=1.0)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._drawn:
            self._bars.remove_task(self._task)
            _display.leave()

    def update(self, record: JobRecord) -> None:
        """Show the progress of the job."""
        stage = record.stage if record.state == "running" else record.state
        if record.state == "queued":
            stage = f"queued, {record.stage}"
        fraction = 1.0 if record.state == "succeeded" else record.progress.fraction
        line = f"{record.name or f'{record.kind} {record.id[:ID_SHOWN]}'}: {stage}"
        if self._drawn:
            # Else drawn every tenth of a second: a job that ends before would have no name.
            changed = line != self._line
            self._bars.update(self._task, description=line, completed=fraction, refresh=changed)
        elif line != self._line:
            self._console.print(f"{fraction:4.0%}  {line}", markup=False, highlight=False)
        self._line = line


def _has_widgets() -> bool:
    try:
        import_module("ipywidgets")
    except ImportError:
        return False
    return True


class _Display:
    """The bars of a process: a terminal has one display that is redrawn."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._users = 0

    def enter(self) -> Progress:
        with self._lock:
            if self._users == 0:
                self._bars = Progress(
                    TextColumn("{task.description}", markup=False),
                    BarColumn(),
                    TaskProgressColumn(),
                    TimeElapsedColumn(),
                    console=Console(stderr=True),
                    transient=True,
                )
                self._bars.start()
            self._users += 1
            return self._bars

    def leave(self) -> None:
        with self._lock:
            self._users -= 1
            if self._users == 0:
                self._bars.stop()


_display: Final = _Display()
