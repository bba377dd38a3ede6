"""Collections to compare: meshes of several classes, and large ones of signatures alone."""

import numpy as np

from broker.contracts import DissimilaritiesPayload, DissimilarityParameters, spectrum_key
from broker.store import DEFAULT_KEYS, Store
from solver.mesh import triangle_mesh
from solver.similarity import SAMPLINGS, Signature
from tests.solver.shapes import blob, cube, moved, torus
from tests.worker.figures import off
from tests.worker.records import shape_record

VERTICES = 100

CLASSES = {
    "blob": blob(2),
    "torus": torus(20, 10),
    "box": triangle_mesh(cube(5).vertices * [1.0, 1.5, 2.2], cube(5).faces),
}
"""Shapes of a few hundred vertices."""


def class_files(each: int = 2) -> list[tuple[str, bytes]]:
    """Class and file of some shapes, each rotated and scaled differently."""
    return [
        (name, off(turned.vertices, turned.faces))
        for name, mesh in CLASSES.items()
        for turned in (moved(mesh, seed, scale=1.0 + seed) for seed in range(each))
    ]


def name_of(shape: str, parameters: DissimilarityParameters) -> str:
    """Cache name of the signature of a shape without mesh."""
    return parameters.signature_name(
        spectrum_key(parameters, shape_record(shape, vertices=VERTICES))
    )


def imagined(
    store: Store, count: int, parameters: DissimilarityParameters, seed: int = 0
) -> DissimilaritiesPayload:
    """Submit the comparison of shapes that have only signatures.

    These are random metrics, each of its own dimension.
    """
    random = np.random.default_rng(seed)
    shapes = tuple(f"imagined-{seed}-{k}" for k in range(count))
    for shape in shapes:
        record = shape_record(shape, vertices=VERTICES, faces=100)
        store.client.set(DEFAULT_KEYS.shape(shape), record.model_dump_json())
        points = random.standard_normal((len(SAMPLINGS), 10, int(random.integers(2, 6))))
        distances = np.linalg.norm(points[:, :, None] - points[:, None], axis=3)
        nothing = np.zeros((len(SAMPLINGS), 10, 0))
        found = Signature(np.zeros((len(SAMPLINGS), 10), dtype=np.int64), distances, nothing)
        store.spectra.put(name_of(shape, parameters), found.to_bytes())
    return DissimilaritiesPayload(shapes=shapes, labels=None, parameters=parameters)
