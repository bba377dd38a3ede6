"""Circuit breaker: one process tries for all, forked ones among them."""

import subprocess
import sys

# In a process of its own: this one may have threads, which do not survive a fork.
PROGRAM = """
import os
from types import SimpleNamespace
from broker import circuit_breaker

now = 100.0
circuit_breaker.time = SimpleNamespace(monotonic=lambda: now)
breaker = circuit_breaker.CircuitBreaker()

def here():
    return breaker.is_open()

def fork():
    pid = os.fork()
    if pid == 0:
        os._exit(breaker.is_open())
    return bool(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))

assert [here(), fork()] == [False, False]
breaker.open(60.0)
assert [here(), fork()] == [True, True]
now += 60.0
assert [fork(), here(), fork()] == [False, True, True]
# The one that tried has died.
now += 60.0
assert [here(), fork()] == [False, True]
breaker.close()
assert [fork(), here()] == [False, False]
"""


def test_one_process_tries_for_all() -> None:
    subprocess.run([sys.executable, "-c", PROGRAM], check=True)
