"""Clients and their jobs, blocking and asynchronous, with one interface."""

from isomatch._clients.async_client import AsyncClient
from isomatch._clients.async_job import AsyncJob
from isomatch._clients.async_landmark_job import AsyncLandmarkJob
from isomatch._clients.client import Client
from isomatch._clients.job import Job
from isomatch._clients.landmark_job import LandmarkJob

__all__ = ["AsyncClient", "AsyncJob", "AsyncLandmarkJob", "Client", "Job", "LandmarkJob"]
