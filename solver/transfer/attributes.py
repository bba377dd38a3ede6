"""Attributes: named values of vertices or faces, and how each kind of them is carried."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol

import numpy as np
import numpy.typing as npt

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import OptionError, TransferError
from solver.transfer.overlap import FACES, VERTICES
from solver.transfer.skinning import normalised_weights, parents_among, strongest_weights

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

_LARGEST_LABEL: Final = 2.0**53
"""Whole numbers up to this are exact in double precision."""

_ROW: Final = {None: "vertex", VERTICES: "vertex", FACES: "face"}


@dataclass(frozen=True, eq=False)
class Attribute:
    """Values of the vertices or the faces of a file.

    Parameters
    ----------
    name
        Its name.
    values
        (V,) or (V, n), row i of vertex or face i of the file: float64, int64, or text of one
        column. Colours are in 0..1.
    columns
        Names of the n columns, such as those of joints; empty if they have none.
    on
        `VERTICES`, `FACES` or `CORNERS`; None if the file does not say, so that the number of rows
        decides.
    parents
        Of skinning weights, the column of the parent of each joint, -1 for none; empty if they are
        not known.
    """

    name: str
    values: npt.NDArray[Any]
    columns: tuple[str, ...] = ()
    on: str | None = None
    parents: tuple[int, ...] = ()

    @property
    def width(self) -> int:
        """Number of columns; 0 for one value of each vertex."""
        return self.values.shape[1] if self.values.ndim == 2 else 0

    @property
    def is_text(self) -> bool:
        """Whether the values are text."""
        return self.values.dtype.kind == "U"


class Along(Protocol):
    """A map along which values are carried: a :class:`.PullBack` or an :class:`.Overlap`."""

    @property
    def reached(self) -> IntArray:
        """Rows, by the user's numbers, that have an image."""

    def means(self, values: FloatArray) -> FloatArray:
        """Return weighted means of values."""

    def majority(self, labels: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the labels of greatest weight."""

    def spread(self, values: npt.NDArray[Any], missing: Any) -> npt.NDArray[Any]:
        """Return values by the user's numbers, with others where there is none."""


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
        numbers or text, or, if they are named or there are no others, floats that are all whole;
        colours are called "colors". Skinning weights are called "weights", or
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
    if kind == LABELS and (names or not known):
        known |= {one.name: one for one in map(with_whole_numbers, attributes) if _is_of(one, kind)}
    absent = [name for name in names if name not in known]
    if absent:
        message = f"there are no {kind} called {absent[0]!r}; {_there(known)}"
        raise OptionError("names", message)
    if not known:
        message = f"the file has no {kind}; {_there_of_kinds(attributes)}"
        raise OptionError("what", message)
    return tuple(known[name] for name in names) if names else tuple(known.values())


def with_whole_numbers(attribute: Attribute) -> Attribute:
    """Return an attribute of floats that are all whole as one of integers, any other as it is.

    Rows without a value (nan) have the label -1, as rows without a partner.
    """
    values = attribute.values
    if values.dtype.kind != "f" or np.isnan(values).all():
        return attribute
    values = np.where(np.isnan(values), -1.0, values)
    if not (np.abs(values) <= _LARGEST_LABEL).all():
        return attribute
    whole = np.rint(values)
    same = (whole == values).all()
    return replace(attribute, values=whole.astype(np.int64)) if same else attribute


def carried(
    attribute: Attribute,
    kind: str,
    along: Along,
    influences: int | None = None,
    onto: str = VERTICES,
) -> Attribute:
    """Carry an attribute of X to Y.

    Parameters
    ----------
    attribute
        Of X, as :func:`selected` returns it for `kind`. Rows with nan have no value.
    kind
        One of `KINDS`. Labels are those of greatest weight, all others weighted means.
    along
        The map from the vertices or faces of Y to those of X.
    influences
        Of skinning weights, how many of each vertex are kept; None for all.
    onto
        Whether `along` starts from `VERTICES` or from `FACES` of Y.

    Returns
    -------
    The attribute of the same name of Y. Vertices of the file that no face uses, faces that were
    dropped, and those whose image has no value, have nan, -1 or an empty text.

    Raises
    ------
    TransferError
        Rows are missing, numbers are infinite, or weights are negative.
    """
    values = attribute.values
    if kind == LABELS:
        missing = "" if attribute.is_text else -1
        found = along.spread(along.majority(values), missing)
        return replace(attribute, values=found, on=onto)
    numbers = values.astype(np.float64)
    if np.isinf(numbers).any():
        row = int(np.argwhere(np.isinf(numbers))[0, 0])
        raise TransferError(f"{attribute.name!r} of {_ROW[attribute.on]} {row} is infinite")
    known = ~np.asarray(np.isnan(numbers).any(axis=tuple(range(1, numbers.ndim))))
    if kind == SKINNING:
        means = _known_means(along, normalised_weights(numbers), known)
        means = normalised_weights(strongest_weights(means, influences))
    else:
        means = _known_means(along, numbers, known)
    return replace(attribute, values=along.spread(means, np.nan), on=onto)


def _known_means(along: Along, values: FloatArray, known: BoolArray) -> FloatArray:
    """Means of the values that are known, nan where most of the weight is on others.

    So what has a value neither grows nor shrinks on the way: where a part of a surface has no
    partner, values that were carried there have gaps.
    """
    if known.all():
        return along.means(values)
    columns = (slice(None), *[None] * (values.ndim - 1))
    shares = along.means(known.astype(np.float64))[columns]
    sums = along.means(np.where(known[columns], values, 0.0))
    return np.where(shares >= 0.5, sums / np.maximum(shares, 0.5), np.nan)


def _is_of(attribute: Attribute, kind: str, named: bool = False) -> bool:
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
            one
            for one in attributes
            if one.values.ndim == 1 and one.values.dtype.kind in "if" and one.on != FACES
        ]
        if not joints:
            message = f"the file has no skinning weights; {_there_of_kinds(attributes)}"
            raise OptionError("what", message)
        table = np.stack([one.values.astype(np.float64) for one in joints], axis=1)
        skin = Attribute(WEIGHTS_NAME, table, tuple(one.name for one in joints), joints[0].on)
    columns = skin.columns or tuple(f"joint{place}" for place in range(skin.width))
    absent = [name for name in names if name not in columns]
    if absent:
        message = f"there is no joint called {absent[0]!r}; {_there(columns)}"
        raise OptionError("names", message)
    places = [columns.index(name) for name in names] if names else list(range(len(columns)))
    chosen = tuple(columns[place] for place in places)
    parents = parents_among(skin.parents, places) if skin.parents else ()
    return replace(skin, values=skin.values[:, places], columns=chosen, parents=parents)


def _there_of_kinds(attributes: Sequence[Attribute]) -> str:
    """Name what there is, such as "there are 'height' (scalars)"."""
    kinds = (LABELS, COLORS, SCALARS, VECTORS)
    own = [next((kind for kind in kinds if _is_of(one, kind)), SKINNING) for one in attributes]
    return _there([one.name for one in attributes], own)


def _there(names: Iterable[str], kinds: Sequence[str] = ()) -> str:
    said = [repr(name[:40]) for name in names]
    said = [f"{name} ({kind})" for name, kind in zip(said, kinds, strict=True)] if kinds else said
    return f"there are {', '.join(said[:20])}" if said else "there are none"
