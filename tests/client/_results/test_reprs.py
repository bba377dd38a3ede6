"""Short representations of what has large arrays."""

import numpy as np
from isomatch import CarriedLandmarks, Geometry, LandmarkSet, PrototypePoints, Shape

from service.http.openapi.examples import EXAMPLES

MANY = np.zeros((1000, 3))
SURFACE = Geometry(MANY, np.zeros((1996, 3), dtype=np.int64), np.arange(1000), None)


def test_surfaces_and_prototypes() -> None:
    assert repr(SURFACE) == str(SURFACE) == "<Geometry of 1000 vertices and 1996 triangles>"
    points = PrototypePoints(MANY, np.arange(1000), np.eye(1000), np.eye(1000), SURFACE)
    assert repr(points) == str(points) == "<PrototypePoints of 1000 points>"


def test_shapes() -> None:
    shape = Shape.model_validate(EXAMPLES["answers"]["get_shape"]["200"]["example"])
    shown = f"<Shape {shape.id} 'cat0.off' of {shape.vertices} vertices, {shape.faces} faces>"
    assert repr(shape) == str(shape) == shown


def test_landmarks() -> None:
    labels = tuple(map(str, range(30)))
    sure = np.where(np.arange(30) == 1, np.nan, 0.876)
    found = CarriedLandmarks(labels, MANY[:30], sure, sure, sure, sure, sure, sure[:1])
    assert repr(found) == "<CarriedLandmarks of 29 of 30 landmarks>"
    heading, first, second, *others = str(found).splitlines()
    assert heading == "29 of 30 landmarks carried"
    assert (first, second, others[-1]) == ("  0: confidence 0.88", "  1: missing", "  and 10 more")
    assert repr(LandmarkSet(labels, MANY[:30])) == "<LandmarkSet of 30 landmarks>"
    assert repr(LandmarkSet(labels, MANY[:30], "a")) == "<LandmarkSet of 30 landmarks of 'a'>"
