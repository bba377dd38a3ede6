"""The eigensolver compared with SciPy's: ``python -m bench.spectrum``.

The 100 smallest eigenpairs of the Laplace-Beltrami operator, by
:mod:`solver.shape.laplacian.eigensolver` and by plain
``scipy.sparse.linalg.eigsh(L, k=100, M=M, sigma=-0.01)``, in turn, in one process, on one thread;
times include the assembly of matrices. The table has the residuals ‖L φ − λ M φ‖ in the norm of
M⁻¹, relative to the greatest eigenvalue, and the greatest relative difference of eigenvalues.
"""

import time
from dataclasses import asdict, dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh
from threadpoolctl import threadpool_limits

from bench.command_line import command_line, parsed, print_json
from bench.sizes import meshes_by_size, size_options
from solver.arrays import FloatArray
from solver.mesh import TriangleMesh
from solver.shape.laplacian import laplace_beltrami_spectrum, laplacian

SIZES = 5_000, 10_000, 28_000, 52_000
EIGENPAIRS = 100
_REPETITIONS = 3


@dataclass(frozen=True)
class Row:
    """Medians over repetitions on one mesh; residuals and errors are the greatest."""

    vertices: int
    seconds_ours: float
    seconds_scipy: float
    ratio: float
    max_relative_error: float
    residual_ours: float
    residual_scipy: float


def compare(mesh: TriangleMesh) -> Row:
    """Compute the eigenpairs of a mesh, scaled to unit area, by both in turn."""
    mesh = mesh.scaled(1.0 / np.sqrt(mesh.area))
    times = np.empty((_REPETITIONS, 2))
    for row in times:
        started = time.perf_counter()
        ours = laplace_beltrami_spectrum(mesh, EIGENPAIRS)
        between = time.perf_counter()
        stiffness, mass = laplacian(mesh)
        masses = sp.diags_array(mass).tocsc()
        values, functions = eigsh(stiffness, k=EIGENPAIRS, M=masses, sigma=-0.01)
        row[:] = between - started, time.perf_counter() - between
    order = np.argsort(values)
    values, functions = values[order], functions[:, order]
    # Eigenvalue 0 has no relative error.
    error = np.abs(ours.eigenvalues[1:] / values[1:] - 1.0).max()
    return Row(
        mesh.n_vertices,
        float(np.median(times[:, 0])),
        float(np.median(times[:, 1])),
        float(np.median(times[:, 0] / times[:, 1])),
        float(error),
        residual(stiffness, mass, ours.eigenvalues, ours.eigenfunctions),
        residual(stiffness, mass, values, functions),
    )


def residual(
    stiffness: sp.csc_array, mass: FloatArray, values: FloatArray, functions: FloatArray
) -> float:
    """Greatest ‖L φ − λ M φ‖ in the norm of M⁻¹, relative to the greatest eigenvalue."""
    left = stiffness @ functions - mass[:, None] * functions * values
    return float(np.sqrt((left**2 / mass[:, None]).sum(axis=0)).max() / values[-1])


def main() -> None:
    """Measure and print a table."""
    parser = command_line(__doc__)
    size_options(parser, SIZES)
    arguments = parsed(parser)
    meshes = meshes_by_size(parser, arguments, SIZES)
    print(
        f"{'vertices':>9}{'ours s':>9}{'scipy s':>9}{'ratio':>8}{'eigenvalues':>13}"
        f"{'residual':>11}{'of scipy':>11}"
    )
    rows = []
    with threadpool_limits(1):
        for mesh in meshes:
            row = compare(mesh)
            rows.append(row)
            print(
                f"{row.vertices:9}{row.seconds_ours:9.2f}{row.seconds_scipy:9.2f}{row.ratio:8.2f}"
                f"{row.max_relative_error:13.1e}{row.residual_ours:11.1e}"
                f"{row.residual_scipy:11.1e}",
                flush=True,
            )
    figures = [asdict(row) for row in rows]
    print_json(arguments, figures[0] if len(figures) == 1 else figures)


if __name__ == "__main__":
    main()
