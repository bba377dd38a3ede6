"""Uploads to the running service, and what it says of them."""

import hashlib
import io
from pathlib import Path

import isomatch
import numpy as np
import pytest
import trimesh

from tests.client.shapes import blob_meshes

ISLANDS = b"OFF\n6 2 0\n0 0 0\n1 0 0\n0 1 0\n5 0 0\n6 0 0\n5 1 0\n3 0 1 2\n3 3 4 5\n"


def test_the_same_file_has_the_same_id(client: isomatch.Client, blobs: tuple[Path, Path]) -> None:
    data = blobs[0].read_bytes()
    shape = client.upload(blobs[0])
    assert shape.id == hashlib.sha256(data).hexdigest()[:32]
    assert (shape.name, shape.file_type, shape.bytes) == ("a.off", "off", len(data))
    assert (shape.vertices, shape.faces) == (642, 1280)
    assert (shape.components, shape.closed, shape.has_colors) == (1, True, False)
    assert shape.area == pytest.approx(blob_meshes()[0].area, rel=1e-6)
    assert shape.warnings == ()
    assert client.upload(data, file_type="off").id == shape.id
    assert client.upload(io.BytesIO(data), file_type="off").id == shape.id
    assert client.shape(shape.id) == shape


def test_arrays_and_meshes_are_uploaded(client: isomatch.Client) -> None:
    mesh = blob_meshes()[0]
    shape = client.upload((mesh.vertices, mesh.faces), name="from arrays")
    assert (shape.name, shape.file_type) == ("from arrays", "ply")
    assert (shape.vertices, shape.faces, shape.closed) == (642, 1280, True)
    assert client.upload(mesh).id == shape.id


def test_vertex_colours_are_uploaded(client: isomatch.Client) -> None:
    mesh = blob_meshes()[0]
    colors = np.tile([200, 100, 50, 255], (len(mesh.vertices), 1))
    colored = trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_colors=colors, process=False)
    assert client.upload(colored).has_colors


def test_all_shapes_are_listed_page_by_page(client: isomatch.Client) -> None:
    scales = np.linspace(1.0, 2.0, 51)
    triangle = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    uploaded = {client.upload((triangle * scale, [[0, 1, 2]])).id for scale in scales}
    assert len(uploaded) == 51  # one more than a page
    listed = [shape.id for shape in client.shapes()]
    assert uploaded <= set(listed)
    assert len(listed) == len(set(listed))
    for shape_id in uploaded:
        client.delete_shape(shape_id)
    assert not uploaded & {shape.id for shape in client.shapes()}


def test_a_deleted_shape_is_gone(client: isomatch.Client) -> None:
    shape = client.upload(ISLANDS, name="islands", file_type="off")
    assert shape.components == 2
    client.delete_shape(shape)
    with pytest.raises(isomatch.NotFound):
        client.shape(shape.id)
    with pytest.raises(isomatch.NotFound):
        client.delete_shape(shape)
