"""Attributes: values of a shape's vertices, by name, and how each kind of them is carried."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from solver.errors import OptionError, TransferError
from solver.transfer.pull_back import PullBack
from solver.transfer.skinning import normalised_weights, strongest_weights

SCALARS: Final = "scalars"
VECTORS: Final = "vectors"
COLORS: Final = "colors"
LABELS: Final = "labels"
SKINNING: Final = "skinning"
KINDS: Final = (SCALARS, VECTORS, COLORS, LABELS, SKINNING)

COLORS_NAME: Final = "colors"
"""Name of the attribute of colours in all formats."""

WEIGHTS_NAME: Final = "weights"
"""Name of the attribute of skinning weights in all formats."""


@dataclass(frozen=True, eq=False)
class Attribute:
    """Values of the vertices of a file.

    Parameters
    ----------
    name
        Its name.
    values
        (V,) or (V, n), row i of vertex i of the file: float64, int64, or text of one column.
        Colours are in 0..1.
    columns
        Names of the n columns, such as those of joints; empty if they have none.
    """

    name: str
    values: npt.NDArray[Any]
    columns: tuple[str, ...] = ()

    @property
    def width(self) -> int:
        """Number of columns; 0 for one value of each vertex."""
        return self.values.shape[1] if self.values.ndim == 2 else 0

    @property
    def is_text(self) -> bool:
        """Whether the values are text."""
        return self.values.dtype.kind == "U"


def selected(
    attributes: Sequence[Attribute], kind: str, names: Sequence[str] = ()
) -> tuple[Attribute, ...]:
    """Select the attributes of a kind.

    Parameters
    ----------
    attributes
        Of a file.
    kind
        One of `KINDS`. Scalars are attributes of one number, vectors of several; labels are whole
        numbers or text; colours are called "colors". Skinning weights are called "weights", or
        else every scalar is the weights of one joint.
    names
        Only these attributes; for skinning, only these joints. None for all of the kind.

    Raises
    ------
    OptionError
        There is none, or one of `names` is not there or is of another kind.
    """
    if kind == SKINNING:
        return (_skin(attributes, names),)
    known = {one.name: one for one in attributes if _is_of(one, kind, bool(names))}
    absent = [name for name in names if name not in known]
    if absent:
        message = f"there are no {kind} called {absent[0]!r}; {_there(known)}"
        raise OptionError("names", message)
    if not known:
        message = f"the file has no {kind}; {_there([one.name for one in attributes])}"
        raise OptionError("what", message)
    return tuple(known[name] for name in names) if names else tuple(known.values())


def carried(
    attribute: Attribute, kind: str, along: PullBack, influences: int | None = None
) -> Attribute:
    """Carry an attribute of X to Y.

    Parameters
    ----------
    attribute
        Of X, as :func:`selected` returns it for `kind`.
    kind
        One of `KINDS`. Labels are those of greatest weight, all others barycentric means.
    along
        The map from the vertices of Y to points of X.
    influences
        Of skinning weights, how many of each vertex are kept; None for all.

    Returns
    -------
    The attribute of the same name of Y. Vertices of the file that no face uses have nan, -1 or an
    empty text.

    Raises
    ------
    TransferError
        Rows are missing, numbers are not finite, or weights are negative.
    """
    values = attribute.values
    if kind == LABELS:
        missing = "" if attribute.is_text else -1
        found = along.spread(along.majority(values), missing)
        return Attribute(attribute.name, found, attribute.columns)
    numbers = values.astype(np.float64)
    if not np.isfinite(numbers).all():
        row = int(np.argwhere(~np.isfinite(numbers))[0, 0])
        raise TransferError(f"{attribute.name!r} of vertex {row} is not a finite number")
    if kind == SKINNING:
        means = along.means(normalised_weights(numbers))
        means = normalised_weights(strongest_weights(means, influences))
    else:
        means = along.means(numbers)
    return Attribute(attribute.name, along.spread(means, np.nan), attribute.columns)


def _is_of(attribute: Attribute, kind: str, named: bool) -> bool:
    number = attribute.values.dtype.kind in "if"
    if kind == LABELS:
        return attribute.values.ndim == 1 and attribute.values.dtype.kind in "iU"
    if kind == COLORS:
        return number and attribute.width in (3, 4) and (named or attribute.name == COLORS_NAME)
    if kind == SCALARS:
        return number and attribute.values.ndim == 1
    special = () if named else (COLORS_NAME, WEIGHTS_NAME)
    return number and attribute.width > 0 and attribute.name not in special


def _skin(attributes: Sequence[Attribute], names: Sequence[str]) -> Attribute:
    skin = next((one for one in attributes if one.name == WEIGHTS_NAME and one.width), None)
    if skin is None:
        joints = [
            one for one in attributes if one.values.ndim == 1 and one.values.dtype.kind in "if"
        ]
        if not joints:
            there = _there([one.name for one in attributes])
            raise OptionError("what", f"the file has no skinning weights; {there}")
        table = np.stack([one.values.astype(np.float64) for one in joints], axis=1)
        skin = Attribute(WEIGHTS_NAME, table, tuple(one.name for one in joints))
    columns = skin.columns or tuple(f"joint{place}" for place in range(skin.width))
    absent = [name for name in names if name not in columns]
    if absent:
        message = f"there is no joint called {absent[0]!r}; {_there(columns)}"
        raise OptionError("names", message)
    places = [columns.index(name) for name in names] if names else list(range(len(columns)))
    return Attribute(skin.name, skin.values[:, places], tuple(columns[place] for place in places))


def _there(names: Sequence[str] | dict[str, Attribute]) -> str:
    listed = ", ".join(repr(name[:40]) for name in list(names)[:20])
    return f"there are {listed}" if listed else "there are none"
