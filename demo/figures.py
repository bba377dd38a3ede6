"""The two figures of the demo, and the error of an answer against the truth."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.mesh import triangle_mesh
from solver.registration.surface import MIRROR
from solver.shape.geodesics import GeodesicGraph
from synthetic import HumanProportions, SyntheticShape, human


@dataclass(frozen=True)
class Figures:
    """One body in two poses and two triangulations, so that no vertex has an exact partner."""

    source: SyntheticShape
    target: SyntheticShape

    def errors(self, pairs: IntArray) -> tuple[FloatArray, FloatArray]:
        """Geodesic distance on the target between each answer and the truth, per √area.

        Parameters
        ----------
        pairs
            (n, 2) int64, matched vertices of source and target.

        Returns
        -------
        direct, mirrored
            (n,) float64 each, against the truth and against its mirror image: a symmetric body
            has two correspondences of no distortion, and its surface does not tell left from
            right.
        """
        mesh = triangle_mesh(self.target.vertices, self.target.faces)
        nearest = KDTree(self.target.rest)
        start = self.source.rest[pairs[:, 0]]
        distances = GeodesicGraph(mesh).distances(pairs[:, 1]) / np.sqrt(mesh.area)
        rows = np.arange(len(pairs))
        direct = distances[rows, nearest.query(start)[1]]
        mirrored = distances[rows, nearest.query(start * MIRROR)[1]]
        return direct, mirrored


def generate(vertices: int, proportions: HumanProportions | None = None) -> Figures:
    """Generate a body standing and walking.

    Parameters
    ----------
    vertices
        Vertices of the standing one; the other has a fifth fewer.
    proportions
        Of the body; by default the standard one, which is symmetric.
    """
    return Figures(
        human("standing", proportions, resolution=vertices, seed=1),
        human("walking", proportions, resolution=vertices * 4 // 5, seed=2),
    )


def write_off(path: Path, shape: SyntheticShape, number: str = "%.9g") -> None:
    """Write a shape as an OFF file, coordinates in a format of C."""
    with path.open("w") as file:
        file.write(f"OFF\n{len(shape.vertices)} {len(shape.faces)} 0\n")
        np.savetxt(file, shape.vertices, fmt=number)
        np.savetxt(file, np.insert(shape.faces, 0, 3, axis=1), fmt="%d")
