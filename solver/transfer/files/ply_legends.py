"""Comments of PLY files that say which text each number of a property stands for.

A line ``comment label NAME NUMBER TEXT`` says it of a number of the property NAME.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from solver.transfer.files.limits import text_column

_MOST_BYTES: Final = 1 << 19
"""Bytes of all legends of a file: headers are read up to twice as many."""

_CODE: Final = re.compile("[0-9]{1,10}")

Columns = Mapping[str, npt.NDArray[Any]]


class Legends:
    """Legends of the properties of a file, as long as all of them fit into its header."""

    def __init__(self) -> None:
        self._left = _MOST_BYTES

    def comments(self, name: str, texts: Sequence[str]) -> list[str]:
        """Return the lines for a property whose number i stands for text i.

        One line says that there is no legend where it would be too long.
        """
        # A line break would end the comment.
        lines = [
            f"comment label {name} {code} {' '.join(text.splitlines())}"
            for code, text in enumerate(texts)
        ]
        size = sum(len(line.encode()) + 1 for line in lines)
        if size > self._left:
            return [f"comment the {len(texts)} labels of {name} are too long for this header"]
        self._left -= size
        return lines


def labels_in_words(columns: Columns, comments: Sequence[str]) -> dict[str, npt.NDArray[np.str_]]:
    """Return the columns of whole numbers that all have a text by the comments, as text."""
    legends: dict[str, dict[int, str]] = {}
    for comment in comments:
        word, name, code, text = [*comment.split(" ", 3), "", "", ""][:4]
        if word == "label" and _CODE.fullmatch(code):
            legends.setdefault(name, {})[int(code)] = text
    found = {}
    for name, legend in legends.items():
        values = columns.get(name)
        if values is None or values.dtype.kind != "i":
            continue
        codes, place = np.unique(values, return_inverse=True)
        if all(code in legend for code in codes.tolist()):
            found[name] = text_column([legend[code] for code in codes.tolist()], place)
    return found
