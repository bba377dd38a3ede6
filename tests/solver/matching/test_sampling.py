"""The sampling stage: sizes of the levels, and the spectra that all parts take theirs from."""

import numpy as np
import pytest

from solver.control import Control
from solver.matching import MatchOptions, match
from solver.matching.sampling import sample
from solver.shape import Shape
from solver.shape.choices import Eigenfunctions
from tests.solver import shapes


@pytest.mark.parametrize("metric", [("geodesic",), ("diffusion", "geodesic")])
def test_as_many_target_as_source_samples_are_matched(metric: tuple[str, ...]) -> None:
    source, target = Shape(shapes.blob(1)), Shape(shapes.blob(2))
    options = MatchOptions(points=9, metric=metric, oversampling=1, orientation=False)
    assert len(match(source, target, options).best.source) == 9


@pytest.mark.parametrize(
    ("options", "needed"),
    [
        (MatchOptions(points=8), 100),
        (
            MatchOptions(
                points=8,
                orientation=False,
                descriptor=(Eigenfunctions(count=60),),
                first_order_weight=0.5,
            ),
            61,
        ),
    ],
)
def test_a_spectrum_is_computed_once(options: MatchOptions, needed: int) -> None:
    assert options.least_eigenpairs == needed
    shape = Shape(shapes.torus(20, 10), eigenpairs=50)
    sample(shape, shape, options.settled(1.0), Control())
    few, many = shape.spectrum(), shape.spectrum(needed)
    assert (few.n_eigenpairs, many.n_eigenpairs) == (50, needed)
    assert np.shares_memory(few.eigenfunctions, many.eigenfunctions)
