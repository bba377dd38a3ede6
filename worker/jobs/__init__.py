"""The jobs: from a payload through the solver to a stored result.

RQ imports ``run`` and ``stopped`` from here, by the names that queued jobs contain.
"""

from worker.jobs.dissimilarities import arrays_of, result_of
from worker.jobs.entry_points import run, stopped, worker_settings
from worker.jobs.matches import MatchInput, match_shapes
from worker.jobs.meshes import mesh_from_bytes, mesh_to_bytes
from worker.jobs.options import options_of
from worker.jobs.problems import timed_out
from worker.jobs.torus import torus_file

__all__ = [
    "MatchInput",
    "arrays_of",
    "match_shapes",
    "mesh_from_bytes",
    "mesh_to_bytes",
    "options_of",
    "result_of",
    "run",
    "stopped",
    "timed_out",
    "torus_file",
    "worker_settings",
]
