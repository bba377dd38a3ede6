"""Statistics of registered templates: what the arrays mean."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from isomatch import Registration

from service.http.openapi.examples import EXAMPLES
from solver.arrays import FloatArray
from solver.mesh import triangle_mesh
from solver.templates import ShapeStatistics, shape_statistics
from worker.jobs.registered_files import rows_of_file

EXAMPLE: dict[str, Any] = EXAMPLES["answers"]["get_result"]["200"]["registration"]
# No face uses vertex 0; vertices 5 and 6 are merged with 2 and 3.
VERTICES = np.array([[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1], [1, 0, 0], [0, 1, 0.0]])
MESH = triangle_mesh(VERTICES, np.array([[1, 2, 3], [5, 4, 6]]))


def registration() -> tuple[Registration, ShapeStatistics]:
    random = np.random.default_rng(3)
    found = shape_statistics(MESH.vertices + 0.1 * random.normal(size=(4, MESH.n_vertices, 3)))
    arrays: dict[str, FloatArray] = {
        "mean": rows_of_file(MESH, found.mean),
        "components": rows_of_file(MESH, found.components),
        "scores": found.scores,
    }
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **arrays)
    result = Registration.from_json(json.dumps(EXAMPLE))
    result._archive = stream.getvalue()
    return result, found


def test_the_shapes_of_scores_are_the_aligned_specimens() -> None:
    result, found = registration()
    shapes = result.shape_of(result.scores)
    np.testing.assert_allclose(shapes, rows_of_file(MESH, found.alignment.positions), atol=1e-12)
    np.testing.assert_allclose(result.shape_of(result.scores[1]), shapes[1])
    np.testing.assert_allclose(result.shape_of(np.zeros(3)), result.mean)
    for wrong in ([1.0], 1.0, np.zeros((3, 4))):
        with pytest.raises(ValueError, match="give 3 scores, one for each component"):
            result.shape_of(wrong)


def test_directions_are_orthonormal_over_the_vertices_of_the_mesh() -> None:
    result, _ = registration()
    own = result.directions[:, MESH.vertex_ids].reshape(3, -1)
    np.testing.assert_allclose(own @ own.T, np.eye(3), atol=1e-12)
    np.testing.assert_array_equal(result.directions[:, [5, 6, 0]], result.directions[:, [2, 3, 1]])


def test_names_of_the_specimens_are_counted(tmp_path: Path) -> None:
    result, _ = registration()
    count = len(result.specimens)
    with pytest.raises(ValueError, match=f"{count} specimens have as many names, not {count + 1}"):
        result.save_meshes(tmp_path, ["name"] * (count + 1))
