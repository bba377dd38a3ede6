"""The jobs: from a payload through the solver to a stored result."""

from worker.jobs.dissimilarities import result_of
from worker.jobs.failures import newer_version
from worker.jobs.matches import Side, match_shapes, result_from_blob
from worker.jobs.meshes import mesh_from_bytes, mesh_of, mesh_to_bytes
from worker.jobs.runner import Runner
from worker.jobs.spectra import surface_spectra
from worker.jobs.torus import torus_file

__all__ = [
    "Runner",
    "Side",
    "match_shapes",
    "mesh_from_bytes",
    "mesh_of",
    "mesh_to_bytes",
    "newer_version",
    "result_from_blob",
    "result_of",
    "surface_spectra",
    "torus_file",
]
