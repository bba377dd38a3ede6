"""Limits of a job's memory and time, and the worker after a job exceeds them."""

import gzip
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from broker.contracts import (
    ConsistentMapsPayload,
    JobRecord,
    JobState,
    MatchParameters,
    MatchPayload,
    Payload,
    PicturePayload,
    PrototypeValidationPayload,
    RegistrationPayload,
    SpectrumKey,
    prototype_id,
    shape_id,
)
from broker.queue import JobQueue, QueueSettings
from broker.store import Store
from solver.arrays import npz_bytes
from solver.templates import RegisteredTemplate, register_template
from tests.worker.families import family
from tests.worker.figures import blob_file
from tests.workers import ended, validation, worker
from worker.jobs import registered_files
from worker.jobs.runner import Runner
from worker.settings import WorkerSettings

ROOT = Path(__file__).resolve().parents[3]

linux = pytest.mark.skipif(sys.platform != "linux", reason="the limit is on address space")

LONG = MatchParameters(points=256, alternatives=32, coarse_points=10)


def failed(record: JobRecord, slug: str) -> None:
    assert record.state is JobState.FAILED
    assert record.error is not None
    assert record.error.slug == slug
    assert record.error.status == 422


@linux
def test_memory_is_limited_beyond_what_is_mapped() -> None:
    program = """
import numpy as np
kept = np.ones(2**24)
from broker.processes import limit_memory
limit_memory(0)
limit_memory(100)
small = np.ones(2**22)
try:
    np.ones(2**25)
except MemoryError:
    print("limited")
"""
    said = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert said.stdout.strip() == "limited", said.stderr


@linux
@pytest.mark.parametrize("moment", ["at once", "before the child asks for it"])
def test_a_fork_does_not_outlive_its_parent(moment: str) -> None:
    program = f"""
import os, signal, time
from broker.processes import forks_die_with_parent
parent = os.getpid()
def wait():
    while os.getppid() == parent:
        time.sleep(0.01)
if {moment != "at once"}:
    os.register_at_fork(after_in_child=wait)
forks_die_with_parent()
ready, tell = os.pipe()
if os.fork() == 0:
    os.write(tell, b".")
    time.sleep(5)
    os.write(1, b"survived")
    os._exit(0)
if {moment == "at once"}:
    os.read(ready, 1)
os.kill(parent, signal.SIGKILL)
"""
    # The pipe of the output is closed only when the child is gone too.
    said = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert said.returncode == -9, said.stderr
    assert said.stdout == ""


@linux
def test_estimated_memory_of_a_spectrum() -> None:
    """The estimate is close to the memory that is mapped."""
    program = """
from pathlib import Path
from solver.shape.laplacian.spectrum import laplace_beltrami_spectrum, spectrum_memory
from tests.solver import shapes
from broker.processes import limit_memory, memory_left

def peak():
    lines = Path("/proc/self/status").read_text().splitlines()
    return {line.split(":")[0]: line.split()[1] for line in lines if line.startswith("Vm")}

assert memory_left() == float("inf")
laplace_beltrami_spectrum(shapes.icosphere(4))  # loads what is loaded once
mesh = shapes.icosphere(5)
mesh.components
limit_memory(1000)
print(memory_left() / 2**20)
before = int(peak()["VmSize"])
laplace_beltrami_spectrum(mesh)
print(1024 * (int(peak()["VmPeak"]) - before) / spectrum_memory(mesh.n_vertices, 100))
"""
    one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    said = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env={**os.environ, **one_thread},
        capture_output=True,
        text=True,
        check=True,
    )
    left, ratio = map(float, said.stdout.split())
    assert 990.0 < left <= 1000.0
    assert 0.7 < ratio < 2.0


@linux
def test_a_job_beyond_the_memory_limit_fails_alone(queue: JobQueue) -> None:
    large = blob_file(5)
    with worker(queue, ISOMATCH_JOB_MEMORY_MB="40"):
        assert ended(queue, validation(queue, large)).state is JobState.SUCCEEDED
        shape = shape_id(large)
        # The eigenfunctions alone are 25 MB, and are not all that is needed.
        parameters = MatchParameters(eigenpairs=300)
        payload = MatchPayload(source=shape, target=shape, parameters=parameters)
        refused = ended(queue, queue.submit(payload).id)
        failed(refused, "out-of-memory")
        assert refused.error is not None
        assert "10242 vertices" in refused.error.detail
        assert "`simplify`" in refused.error.detail
        assert ended(queue, validation(queue, blob_file(1))).state is JobState.SUCCEEDED


@linux
def test_a_shape_beyond_the_memory_limit_is_left_out_of_a_collection(queue: JobQueue) -> None:
    """Its spectrum alone would take 125 MiB."""
    files = [*family(2), blob_file(5)]
    first, second, large = map(shape_id, files)
    parameters = MatchParameters(points=12, coarse_points=6, dense=True)
    payloads: dict[str, Payload] = {
        "specimens": RegistrationPayload(
            template=first, shapes=(second, large), scale=True, parameters=parameters
        ),
        "shapes": ConsistentMapsPayload(shapes=(first, second, large), parameters=parameters),
    }
    with worker(queue, ISOMATCH_JOB_MEMORY_MB="110"):
        for data in files:
            assert ended(queue, validation(queue, data)).state is JobState.SUCCEEDED
        for reported, payload in payloads.items():
            record = ended(queue, queue.submit(payload).id)
            assert record.state is JobState.SUCCEEDED, record.error
            packed = queue.store.results.document(record.id)
            assert packed is not None
            document = json.loads(gzip.decompress(packed))
            reports = {one["shape"]: one["reason"] for one in document[reported]}
            assert "10242 vertices" in reports[large]
            assert "`simplify`" in reports[large]
            assert reports[second] is None


def test_a_job_beyond_the_time_limit_fails_alone(store: Store) -> None:
    queue = JobQueue(store, QueueSettings(job_timeout=1))
    data = blob_file(4)
    with worker(queue):
        ended(queue, validation(queue, data))
        payload = MatchPayload(source=shape_id(data), target=shape_id(data), parameters=LONG)
        failed(ended(queue, queue.submit(payload).id), "timed-out")
        assert ended(queue, validation(queue, blob_file(2))).state is JobState.SUCCEEDED


def test_time_that_runs_out_while_a_file_is_read_is_no_damage(store: Store) -> None:
    queue = JobQueue(store, QueueSettings(interactive_timeout=1))
    archive = npz_bytes({str(number): np.zeros(1) for number in range(40_000)})
    payload = PrototypeValidationPayload(prototype=prototype_id(archive), name="many arrays")
    with worker(queue):
        failed(ended(queue, queue.submit_validation(payload, archive)), "timed-out")


@linux
@pytest.mark.parametrize(
    ("data", "read"),
    [
        ("npz_bytes({'about': large})", "solver.prototype.prototype_from_bytes"),
        ("npz_bytes({'eigenvalues': large})", "solver.shape.laplacian.Spectrum.from_bytes"),
        ("npy_bytes(large)", "solver.similarity.Signature.from_bytes"),
    ],
)
def test_memory_that_runs_out_while_a_file_is_read_is_no_damage(data: str, read: str) -> None:
    program = f"""
import io
import numpy as np
import solver.prototype, solver.similarity, solver.shape.laplacian
from broker.processes import limit_memory
from solver.arrays import npz_bytes

def npy_bytes(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()

large = np.zeros(2**24)
data = {data}
limit_memory(100)
try:
    {read}(data)
except MemoryError:
    print("limited")
"""
    said = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert said.stdout.strip() == "limited", said.stderr


def test_spectra_may_have_a_redis_of_their_own(store: Store, settings: WorkerSettings) -> None:
    assert settings.redis_url is not None
    elsewhere = settings.redis_url.replace("db=1", "db=6")
    apart = Store.open(settings.model_copy(update={"cache_url": elsewhere}), retry_seconds=1)
    key = SpectrumKey("a", 10)
    apart.spectra.put(key, b"spectrum")
    assert apart.spectra.get(key) == b"spectrum"
    assert apart.spectra.lock(key, "me", 1.0)
    assert not store.spectra.has(key)
    assert store.spectra.locked(key)
    apart.cache.flushdb()
    apart.close()


def test_the_file_of_a_registered_match_is_computed_within_its_time(
    queue: JobQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = []

    def watched(*meshes: Any) -> RegisteredTemplate:
        *_, control = meshes
        left.append(control.seconds_left())
        return register_template(*meshes)

    monkeypatch.setattr(registered_files, "register_template", watched)
    files = family(2, 1)
    for data in files:
        Runner(queue, "runner").run(validation(queue, data))
    source, target = map(shape_id, files)
    parameters = MatchParameters.of_whole_surfaces(False)
    match = queue.submit(MatchPayload(source=source, target=target, parameters=parameters)).id
    Runner(queue, "runner").run(match)
    asked = PicturePayload(job=match, specimen=0, format="ply")
    Runner(queue, "runner").run(queue.submit_picture(asked))
    assert queue.store.results.picture(asked) is not None
    assert 0.0 < left[0] < queue.settings.interactive_timeout
