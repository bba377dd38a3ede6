"""Materials of GLB files of several surfaces."""

import numpy as np

from solver.mesh import textured_surface
from solver.mesh.formats import read_glb_with
from solver.mesh.textures import Paint, Texture
from solver.transfer.files import WrittenSurface, write_glb

TRIANGLE = np.array([[0, 1, 2]])


def surface(place: float, grey: int | None = None) -> WrittenSurface:
    """A triangle at a height, with an image of one grey if one is given."""
    vertices = np.array([[0.0, 0, place], [1, 0, place], [0, 1, place]])
    paint = None
    if grey is not None:
        image = Texture(np.full((2, 2, 3), grey, dtype=np.uint8))
        coordinates = np.array([[[0.0, 0], [1, 0], [0, 1]]])
        paint = Paint(coordinates, np.zeros((1, 3)), np.zeros(1, dtype=np.int64), (image,))
    return WrittenSurface(f"at {place}", vertices, TRIANGLE, (), paint)


def test_each_surface_has_its_own_image() -> None:
    read = textured_surface(write_glb([surface(0.0, 10), surface(1.0, 200)]), "glb")
    assert read is not None
    mesh, paint = read
    heights = mesh.vertices[mesh.faces][:, 0, 2]
    greys = [paint.textures[number].pixels.max() for number in paint.texture_of_face]
    assert dict(zip(heights.tolist(), greys, strict=True)) == {0.0: 10, 1.0: 200}


def test_surfaces_without_paint_share_a_material_of_their_own() -> None:
    data = write_glb([surface(0.0, 10), surface(1.0), surface(2.0)])
    tree = read_glb_with(data, lambda file: file.tree)
    painted, *others = (mesh["primitives"][0]["material"] for mesh in tree["meshes"])
    assert len({painted, *others}) == len(tree["materials"]) == 2
    assert others[0] == others[1]
    plain = tree["materials"][others[0]]["pbrMetallicRoughness"]
    assert plain == {"metallicFactor": 0.0}
