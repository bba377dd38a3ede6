"""Workers forked from one process: replaced, stopped together, ended by an error."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from worker.process.process import main

ROOT = Path(__file__).resolve().parents[3]

FORKING = """
import os, signal, sys, time
from broker.telemetry import configure_logging
from worker.process.prefork import fork_workers

configure_logging("WARNING", process="worker")
status = fork_workers(2)
if status is not None:
    sys.exit(status)
signal.signal(signal.SIGUSR1, lambda *_: sys.exit(3))
# One write each: that of two workers at the same time must not mix.
os.write(1, f"{os.getpid()} {os.getppid()}\\n".encode())
time.sleep(60)
"""

SUBREAPER = 36  # PR_SET_CHILD_SUBREAPER
ADOPTING = f"import ctypes; ctypes.CDLL(None).prctl({SUBREAPER}, 1)\n" + FORKING.replace(
    "# One write each",
    """
worker = os.getpid()
if os.fork() == 0:
    while os.getppid() == worker:
        time.sleep(0.01)
    os._exit(1)
# One write each""",
)
"""Orphans become children of the process that forks, as those in a container do of its first one.
Each worker has a child that outlives it for a moment.
"""


@contextmanager
def forking(code: str = FORKING) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        with process:
            yield process
    finally:
        process.kill()


def worker(process: subprocess.Popen[str]) -> int:
    """The next worker that says that it runs."""
    assert process.stdout is not None
    pid, parent = map(int, process.stdout.readline().split())
    assert parent == process.pid
    return pid


def rest(process: subprocess.Popen[str]) -> str:
    """What is said until all processes have ended."""
    assert process.stdout is not None
    return process.stdout.read()


def test_a_worker_that_is_killed_or_leaves_is_replaced() -> None:
    with forking() as process:
        workers = {worker(process), worker(process)}
        for number in (signal.SIGKILL, signal.SIGTERM):
            os.kill(min(workers), number)
            workers.remove(min(workers))
            workers.add(worker(process))
        assert len(workers) == 2
        process.terminate()
        assert rest(process) == ""


@pytest.mark.skipif(sys.platform != "linux", reason="there are no subreapers")
def test_orphans_of_a_killed_worker_are_reaped() -> None:
    with forking(ADOPTING) as process:
        workers = {worker(process), worker(process)}
        for _ in range(2):
            os.kill(min(workers), signal.SIGKILL)
            workers.remove(min(workers))
            workers.add(worker(process))
        process.terminate()
        assert rest(process) == ""
        assert process.wait() == 0


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_stop_is_passed_on(number: signal.Signals) -> None:
    with forking() as process:
        for _ in range(2):
            worker(process)
        process.send_signal(number)
        assert rest(process) == ""
        assert process.wait() == 0


def test_an_error_of_one_ends_all() -> None:
    with forking() as process:
        worker(process)
        os.kill(worker(process), signal.SIGUSR1)
        assert rest(process) == ""
        assert process.wait() == 3


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--count", "0"], "at least 1"),
        (["--jobs", "0"], "at least 1"),
        (["--count", "2", "--burst"], "not allowed with"),
    ],
)
def test_numbers_of_workers_that_make_no_sense_are_refused(
    arguments: list[str],
    reason: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(sys, "argv", ["worker", *arguments])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 2
    assert reason in capsys.readouterr().err
