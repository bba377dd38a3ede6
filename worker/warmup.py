"""Doing a tiny job of each kind before the first real one, so that forked jobs start warm."""

import time

import numpy as np
import trimesh

from solver.mesh import MESH_FORMATS, TriangleMesh, triangle_mesh
from worker.telemetry import logger

log = logger("isomatch.worker")


def warm_up() -> None:
    """Compile and import, in this process, all that jobs will need; forks inherit it.

    A forked job then starts in milliseconds where it would take a good part of a second.
    """
    start = time.perf_counter()
    log.info("warm", seconds=round(time.perf_counter() - start, 3))
