"""The whole service on one machine: API, a private Redis-compatible server, a pool of workers."""

from service.standalone.embedded import EmbeddedServer, server_binary
from service.standalone.pool import WorkerPool
from service.standalone.standalone import KEEP_ALIVE_SECONDS, StartError, listening, serve

__all__ = [
    "KEEP_ALIVE_SECONDS",
    "EmbeddedServer",
    "StartError",
    "WorkerPool",
    "listening",
    "serve",
    "server_binary",
]
