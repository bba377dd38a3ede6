"""Array types of the solver."""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]
"""float64 array; the docstring that uses it gives the shape."""

RealArray: TypeAlias = npt.NDArray[np.float32] | npt.NDArray[np.float64]
"""float32 or float64 array, where either precision will do; the docstring gives the shape."""

IntArray: TypeAlias = npt.NDArray[np.int64]
"""int64 array; the docstring that uses it gives the shape."""

IndexArray: TypeAlias = npt.NDArray[np.uint32]
"""uint32 array of indices in compiled loops, which need not look for negative ones."""

BoolArray: TypeAlias = npt.NDArray[np.bool_]
"""boolean array; the docstring that uses it gives the shape."""
