"""Limits of the process that runs a job: memory, and the life of its parent process."""

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
    """Limit the address space that this process may map in addition to what it has mapped.

    Allocations beyond the limit raise :class:`MemoryError`. Linux only.

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
    """Bytes that this process may still map; infinite without a limit, and outside Linux."""
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
    """Have this process killed when its parent process ends, for whatever reason.

    Parameters
    ----------
    parent
        Id of the parent process.
    """
    if _LIBC is not None:
        _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    else:
        threading.Thread(target=_watch, args=(parent,), daemon=True).start()
    # The parent may have ended already.
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGKILL)


def forks_die_with_parent() -> None:
    """Have each process that this one forks from now on killed when its parent ends.

    The parent's id is read before the fork: afterwards ``getppid`` may already return that of the
    process that inherited the child.
    """
    parents: list[int] = []

    def store_parent() -> None:
        parents[:] = [os.getpid()]

    os.register_at_fork(before=store_parent, after_in_child=lambda: die_with_parent(parents[0]))


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(1.0)
    os.kill(os.getpid(), signal.SIGKILL)
