"""The examples in the docstrings of the mesh functions."""

import doctest

import numpy as np
import pytest

from solver import mesh


@pytest.mark.parametrize("name", ["read_mesh", "triangle_mesh", "simplified"])
def test_examples_run(name: str) -> None:
    function = getattr(mesh, name)
    scope = {"np": np, "triangle_mesh": mesh.triangle_mesh, name: function}
    (examples,) = doctest.DocTestFinder(recurse=False).find(function, name, globs=scope)
    assert examples.examples
    assert doctest.DocTestRunner().run(examples).failed == 0
