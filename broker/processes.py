"""Limits of the process that runs one job: its memory, and that it does not outlive its worker."""

import ctypes
import math
import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Final

_PR_SET_PDEATHSIG: Final = 1
_LIBC: Final = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None


def limit_memory(megabytes: int) -> None:
    """Let this process map so much more memory than it has mapped already.

    What would go over the limit raises :class:`MemoryError` instead of taking the machine down.
    Only on Linux, where the limit is on address space and what is mapped can be read.

    Parameters
    ----------
    megabytes
        The limit in MiB; 0 for none.
    """
    if sys.platform != "linux" or megabytes == 0:
        return
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = _mapped() + megabytes * 1024**2
    if hard != resource.RLIM_INFINITY:
        limit = min(limit, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


def memory_left() -> float:
    """Bytes that this process may map beyond what it has mapped; infinite where nobody says."""
    if sys.platform != "linux":
        return math.inf
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return math.inf if limit == resource.RLIM_INFINITY else float(limit - _mapped())


def _mapped() -> int:
    """Bytes that this process has mapped."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    return pages * os.sysconf("SC_PAGE_SIZE")


def die_with_parent(parent: int) -> None:
    """Let this process be killed when the process that started it is gone, however it went.

    Parameters
    ----------
    parent
        Id of the process that started this one.
    """
    if _LIBC is not None:
        _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    else:
        threading.Thread(target=_watch, args=(parent,), daemon=True).start()
    # It may have gone before it could be watched.
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)


def forks_die_with_parent() -> None:
    """Let every process that this one forks from now on be killed when its parent is gone.

    The parent's id is noted before each fork: a child that asks for it later cannot tell its
    parent from who inherited it.
    """
    parents: list[int] = []

    def note() -> None:
        parents[:] = [os.getpid()]

    os.register_at_fork(before=note, after_in_child=lambda: die_with_parent(parents[0]))


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(1.0)
    os.kill(os.getpid(), signal.SIGKILL)
