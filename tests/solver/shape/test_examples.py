"""Examples in docstrings: they run, and print what they say."""

import doctest
from types import ModuleType

import pytest

from solver.shape import geodesics, sampling, shape


@pytest.mark.parametrize("module", [geodesics, sampling, shape], ids=lambda m: m.__name__)
def test_examples(module: ModuleType) -> None:
    result = doctest.testmod(module)
    assert result.attempted
    assert not result.failed
