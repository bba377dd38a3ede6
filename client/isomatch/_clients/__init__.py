"""Clients and their jobs, blocking and asynchronous, with one interface."""

from isomatch._clients.async_client import AsyncClient
from isomatch._clients.async_job import AsyncJob
from isomatch._clients.client import Client
from isomatch._clients.job import Job

__all__ = ["AsyncClient", "AsyncJob", "Client", "Job"]
