"""NumPy archives of attributes (.npz): an array for each, read without pickle."""

import io
import math
import sys
import zipfile
from collections.abc import Sequence
from typing import Any, BinaryIO, Final, cast

import numpy as np
import numpy.typing as npt

from solver.arrays import array_header, npz_bytes
from solver.errors import TransferError
from solver.transfer.attributes import COLORS_NAME, WEIGHTS_NAME, Attribute
from solver.transfer.files.limits import MOST_COLUMNS, MOST_VALUES, check_size, colors_in_range
from solver.transfer.files.names import renamed

_JOINTS: Final = "joints"
_JOINT_NAMES: Final = "joint_names"
_JOINT_PARENTS: Final = "joint_parents"
_BESIDES: Final = (COLORS_NAME, _JOINTS, _JOINT_NAMES, _JOINT_PARENTS)
"""Arrays that are no columns of values."""

_PLAIN: Final = "save arrays of numbers or text, as array.astype(str) or .astype(float)"
_MOST_BYTES: Final = 2**28
"""Bytes of all arrays, unpacked."""


def read_npz(data: bytes) -> list[Attribute]:
    """Read the arrays of an archive: (V,) or (V, n), of numbers or text.

    `colors` are colours. `weights` (V, J) are skinning weights, with the names of the joints in
    `joint_names` (J,) if they have some, and the numbers of their parents, -1 for none, in
    `joint_parents` (J,); or (V, k) with the numbers of the joints in `joints` (V, k), as in glTF.

    Raises
    ------
    TransferError
        The bytes are no such archive; it has objects, is damaged or too large.
    """
    arrays = _arrays(data)
    names = arrays.pop(_JOINT_NAMES, None)
    weights = arrays.get(WEIGHTS_NAME)
    if weights is not None and _JOINTS in arrays:
        arrays[WEIGHTS_NAME] = dense_weights(arrays.pop(_JOINTS), weights)
    parents = arrays.pop(_JOINT_PARENTS, None) if weights is not None else None
    attributes = []
    for name, array in arrays.items():
        values = _values(name, array)
        columns: tuple[str, ...] = ()
        above: tuple[int, ...] = ()
        if name == COLORS_NAME and values.ndim == 2 and values.shape[1] in (3, 4):
            values = colors_in_range(values)
        elif name == WEIGHTS_NAME:
            columns = () if names is None else _named(names, values)
            above = () if parents is None else _parents(parents, values)
        attributes.append(Attribute(name, values, columns, parents=above))
    return attributes


def write_npz(attributes: Sequence[Attribute]) -> bytes:
    """Return attributes as an archive that :func:`read_npz` reads, without loss.

    An attribute that is called as an array of the format is gets another name (:func:`.renamed`).
    """
    arrays = {one.name: one.values for one in attributes}
    of_weights = (_JOINTS, _JOINT_PARENTS) if WEIGHTS_NAME in arrays else ()
    own = (_JOINT_NAMES, *of_weights)
    arrays = renamed(arrays, own)
    for one in attributes:
        if one.name == WEIGHTS_NAME and one.columns:
            arrays[_JOINT_NAMES] = np.array(one.columns, dtype=np.str_)
        if one.name == WEIGHTS_NAME and one.parents:
            arrays[_JOINT_PARENTS] = np.array(one.parents, dtype=np.int64)
    return npz_bytes(arrays)


def dense_weights(
    joints: npt.NDArray[Any], weights: npt.NDArray[Any], count: int | None = None
) -> npt.NDArray[np.float64]:
    """Return the weights of all joints, from those of a few of each vertex.

    Parameters
    ----------
    joints, weights
        (V, k) numbers of joints, and their weights.
    count
        Number J of joints; None for one more than the greatest number.

    Returns
    -------
    (V, J)

    Raises
    ------
    TransferError
        Shapes differ, or a joint is negative or too large.
    """
    if joints.shape != weights.shape or joints.ndim != 2 or joints.dtype.kind not in "iu":
        raise TransferError("`joints` must be whole numbers, as many of each vertex as `weights`")
    if weights.dtype.kind not in "iuf":
        raise TransferError("`weights` must be numbers")
    # Padding of unused places need not name a joint.
    numbers = np.where(weights == 0, 0, joints).astype(np.int64)
    greatest = MOST_COLUMNS if count is None else count
    if numbers.size and (numbers.min() < 0 or numbers.max() >= greatest):
        wrong = numbers[(numbers < 0) | (numbers >= greatest)].flat[0]
        raise TransferError(f"joint {wrong} does not exist; joints are numbered from 0")
    size = int(numbers.max(initial=0)) + 1 if count is None else count
    check_size(size, len(numbers))
    found = np.zeros((len(numbers), size))
    np.add.at(found, (np.arange(len(numbers))[:, None], numbers), weights.astype(np.float64))
    return found


def _arrays(data: bytes) -> dict[str, npt.NDArray[Any]]:
    if not data.startswith(b"PK"):  # NumPy would suspect a pickle
        raise TransferError("not an archive of arrays (.npz)")
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            entries = archive.zip.infolist()
            if len(entries) > MOST_COLUMNS + len(_BESIDES):
                raise TransferError(f"the archive has more than {MOST_COLUMNS} arrays")
            if sum(entry.file_size for entry in entries) > _MOST_BYTES:
                raise TransferError("the archive is too large when unpacked")
            # As many again may say which joints weights are of.
            if sum(_checked_count(archive.zip, entry) for entry in entries) > 2 * MOST_VALUES:
                raise TransferError(f"the archive has more than {2 * MOST_VALUES} values")
            return {name: _checked_characters(name, archive[name]) for name in archive.files}
    except (TransferError, MemoryError):
        raise
    except Exception as error:  # readers of damaged archives raise anything
        reason = str(error) or type(error).__name__
        if "allow_pickle" in reason:
            reason = f"it has Python objects; {_PLAIN}"
        raise TransferError(f"the archive of arrays (.npz) cannot be read: {reason}") from error


def _checked_characters(name: str, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return an array; one of text whose codes are no characters is refused."""
    kind = array.dtype
    if kind.kind == "U" and kind.itemsize and array.size:
        codes = np.ascontiguousarray(array).view(np.dtype(np.uint32).newbyteorder(kind.byteorder))
        if codes.max() > sys.maxunicode:
            raise TransferError(f"{name[:40]!r} has text with codes that are no characters")
    return array


def _checked_count(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> int:
    """Return the number of values of an array, before it is allocated.

    Raises
    ------
    TransferError
        Its header promises more than its member holds, or is damaged.
    """
    with archive.open(entry) as member:
        try:
            shape, kind = array_header(cast(BinaryIO, member))
        except (ValueError, TypeError, SyntaxError, RecursionError) as error:
            raise TransferError(f"the header of {entry.filename[:100]!r} is damaged") from error
    if kind.hasobject:
        raise TransferError(f"{entry.filename[:100]!r} has Python objects; {_PLAIN}")
    size = kind.itemsize
    for length in shape:
        size *= length
    count = math.prod(shape)
    if size > entry.file_size or (kind.itemsize == 0 and count > MOST_VALUES) or count < 0:
        raise TransferError(f"{entry.filename[:100]!r} promises more values than it has")
    if kind.kind == "S" and 4 * size > _MOST_BYTES:  # as text it has four bytes a character
        raise TransferError(f"the text of {entry.filename[:100]!r} is too long")
    return count


def _values(name: str, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if array.ndim not in (1, 2) or (array.ndim == 2 and not array.shape[1]):
        raise TransferError(
            f"{name!r} has the shape {array.shape}; give (V,) or (V, n), a row for every vertex"
        )
    kind = array.dtype.kind
    if kind == "f":
        return array.astype(np.float64)
    if kind in "bi" or (kind == "u" and not (array > np.iinfo(np.int64).max).any()):
        return array.astype(np.int64)
    if kind == "U" and array.ndim == 1:
        return array
    if kind == "S" and array.ndim == 1:
        try:
            return np.char.decode(array, "utf-8")
        except UnicodeDecodeError as error:
            message = f"{name!r} is text that is not UTF-8; save an array of text (str)"
            raise TransferError(message) from error
    if kind == "u":
        raise TransferError(f"{name!r} has numbers beyond 2^63 - 1")
    raise TransferError(f"{name!r} is of type {array.dtype}; give numbers, or text in one column")


def _named(names: npt.NDArray[Any], values: npt.NDArray[Any]) -> tuple[str, ...]:
    found = tuple(map(str, names.ravel()[: MOST_COLUMNS + 1]))
    if values.ndim != 2 or len(found) != values.shape[1] or len(set(found)) < len(found):
        raise TransferError("`joint_names` must have a different name for each column of `weights`")
    return found


def _parents(numbers: npt.NDArray[Any], values: npt.NDArray[Any]) -> tuple[int, ...]:
    count = values.shape[1] if values.ndim == 2 else 0
    sound = numbers.shape == (count,) and numbers.dtype.kind in "iu"
    sound = sound and bool(((numbers >= -1) & (numbers < count)).all())
    if sound:
        # An ancestor of as many generations as there are joints is one of a cycle.
        above = np.append(numbers.astype(np.int64), -1)
        ancestors = above
        for _ in range(count):
            ancestors = above[ancestors]
        sound = bool((ancestors == -1).all())
    if not sound:
        raise TransferError(
            "`joint_parents` must have the number of the parent of each column of `weights`, -1"
            " for none, without a cycle"
        )
    return tuple(numbers.tolist())
