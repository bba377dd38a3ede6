"""Textured files that were damaged in any way are read or refused."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh import read_mesh
from tests.solver.mesh import mesh_files
from tests.solver.mesh.formats.painted_square import OBJ
from tests.solver.mesh.textures.textured_files import (
    grid,
    image_file,
    ramp,
    textured_glb,
    textured_tree,
    zipped,
    zipped_obj,
)

SMALL = grid(2)
FILES: dict[str, Callable[[FloatArray, IntArray, FloatArray, bytes], bytes]] = {
    "glb": textured_glb,
    "zip": zipped_obj,
}
PICTURE = image_file(ramp(8, 8))
DATA = {kind: write(*SMALL, SMALL[0][:, :2], PICTURE) for kind, write in FILES.items()}
TREE: Any = textured_tree(*SMALL, SMALL[0][:, :2], PICTURE)


def read_or_refuse(data: bytes, file_type: str) -> None:
    try:
        mesh = read_mesh(data, file_type)
    except MeshError:
        return
    assert mesh.colors is None or (
        np.isfinite(mesh.colors).all() and 0.0 <= mesh.colors.min() <= mesh.colors.max() <= 1.0
    )


@pytest.mark.parametrize("kind", FILES)
def test_files_cut_anywhere(kind: str) -> None:
    for end in range(0, len(DATA[kind]), 7):
        with pytest.raises(MeshError):
            read_mesh(DATA[kind][:end], kind)


@settings(max_examples=300)
@given(
    st.sampled_from(sorted(FILES)), st.floats(0.0, 1.0), st.integers(0, 8), st.binary(max_size=8)
)
@pytest.mark.filterwarnings("ignore")
def test_damaged_textured_files(kind: str, place: float, removed: int, inserted: bytes) -> None:
    data = DATA[kind]
    start = int(place * len(data))
    read_or_refuse(data[:start] + inserted + data[start + removed :], kind)


LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 10),
    st.floats(),
    st.text(max_size=4),
    st.sampled_from([5121, 10497, "VEC2", "data:,", "data:;base64,", [], {}, [1, 2], {"index": 0}]),
)


def places_in(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inside = tree.items() if isinstance(tree, dict) else enumerate(tree)
    found = []
    for key, value in inside:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places_in(value, (*path, key))
    return found


PLACES = places_in(TREE[0])


@settings(max_examples=400)
@given(st.lists(st.tuples(st.sampled_from(PLACES), LEAVES), min_size=1, max_size=3))
@pytest.mark.filterwarnings("ignore")
def test_gltf_trees_with_anything_anywhere(changes: list[tuple[tuple[Any, ...], Any]]) -> None:
    tree = json.loads(json.dumps(TREE[0]))
    for path, value in changes:
        at = tree
        try:
            for key in path[:-1]:
                at = at[key]
            at[path[-1]] = value
        except (KeyError, IndexError, TypeError):
            continue
    read_or_refuse(mesh_files.glb_of(tree, TREE[1]), "glb")


@settings(max_examples=150)
@given(st.binary(max_size=60), st.text(max_size=60), st.sampled_from(["map_Kd ", "Kd ", "newmtl "]))
@pytest.mark.filterwarnings("ignore")
def test_any_material_file(raw: bytes, text: str, keyword: str) -> None:
    mtl = b"newmtl skin\n" + keyword.encode() + text.encode() + b"\n" + raw
    read_or_refuse(zipped({"skin.obj": OBJ[:400], "skin.mtl": mtl, "skin.png": PICTURE}), "zip")
