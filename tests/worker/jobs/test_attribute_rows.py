"""Rows of attribute files: of the vertices or of the faces of the shape's file, or refused."""

from dataclasses import replace

import numpy as np
import pytest

from broker.contracts import TransferPayload
from solver.errors import OptionError
from solver.mesh import TriangleMesh, triangle_mesh
from solver.transfer import FACES, VERTICES, Attribute
from tests.solver import shapes
from worker.jobs.attribute_rows import with_rows_known

BLOB = triangle_mesh(shapes.blob(1).vertices, shapes.blob(1).faces)
PAYLOAD = TransferPayload(
    match="m",
    source="the-shape",
    target="t",
    attributes=None,
    what="labels",
    direction="source_to_target",
)


def labels(count: int, on: str | None = None) -> Attribute:
    return Attribute("part", np.arange(count), on=on)


def found(mesh: TriangleMesh, one: Attribute, payload: TransferPayload = PAYLOAD) -> str | None:
    return with_rows_known([one], mesh, payload)[0].on


def test_the_number_of_rows_tells_vertices_from_faces() -> None:
    assert found(BLOB, labels(BLOB.n_vertices)) == VERTICES
    assert found(BLOB, labels(BLOB.n_faces)) == FACES


def test_rows_of_vertices_are_all_of_the_file() -> None:
    mesh = triangle_mesh(np.concatenate([BLOB.vertices, np.ones((2, 3))]), BLOB.faces)
    assert found(mesh, labels(BLOB.n_vertices + 2)) == VERTICES
    for count in (BLOB.n_vertices, BLOB.n_vertices + 1):
        with pytest.raises(OptionError, match="rows, and the file of shape the-shape"):
            found(mesh, labels(count))


def test_of_as_many_faces_as_vertices_the_file_says_or_it_is_vertices() -> None:
    count = BLOB.n_vertices
    even = replace(BLOB, file_rows=(count, count))
    assert found(even, labels(count)) == VERTICES
    assert found(even, labels(count, FACES)) == FACES


def test_what_the_file_says_must_fit() -> None:
    with pytest.raises(OptionError, match=f"{BLOB.n_faces} rows of vertices"):
        found(BLOB, labels(BLOB.n_faces, VERTICES))


def test_both_numbers_are_told_with_what_to_do() -> None:
    has = f"has {BLOB.n_vertices} vertices and {BLOB.n_faces} faces; "
    with pytest.raises(OptionError, match=has + "give a row for every vertex, or for every face"):
        found(BLOB, labels(7))
    with pytest.raises(OptionError, match="there is 1 row, and the file of shape"):
        found(BLOB, labels(1))
    with pytest.raises(OptionError, match=has + "values of corners are not carried"):
        found(BLOB, labels(3 * BLOB.n_faces))


def test_skinning_weights_are_of_vertices() -> None:
    skinning = PAYLOAD.model_copy(update={"what": "skinning"})
    assert found(BLOB, labels(BLOB.n_vertices), skinning) == VERTICES
    with pytest.raises(OptionError, match="of vertices, not of faces"):
        found(BLOB, labels(BLOB.n_faces), skinning)


def test_shapes_of_earlier_versions_have_values_of_vertices_alone() -> None:
    old = replace(BLOB, file_rows=None, face_ids=None)
    assert found(old, labels(BLOB.n_vertices)) == VERTICES
    with pytest.raises(OptionError, match="unknown faces; for values of faces, delete"):
        found(old, labels(BLOB.n_faces))
