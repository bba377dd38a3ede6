"""Lists of labels as text (.seg, .txt): one label a line, as segmentation benchmarks have them."""

import io
from typing import Final

from solver.errors import TransferError
from solver.transfer.attributes import Attribute, with_whole_numbers
from solver.transfer.files.csv_table import column_of
from solver.transfer.files.limits import check_size

_NAME: Final = "label"


def read_label_list(data: bytes) -> list[Attribute]:
    """Read one label, number or text, of each line; numbers that are all whole are labels.

    An empty line between labels is none: an empty text, or -1.

    Raises
    ------
    TransferError
        It is not UTF-8 text, is empty, or has both numbers and text.
    """
    try:
        text = data.decode("utf-8-sig").rstrip()
    except UnicodeDecodeError:
        raise TransferError("the list of labels is not text in UTF-8") from None
    # Not those of Unicode alone, which labels may have.
    lines = io.StringIO(text, newline=None).read().split("\n") if text else []
    if not lines:
        raise TransferError("the list of labels is empty; write one label a line")
    check_size(1, len(lines))
    # numpy.savetxt writes whole numbers as 1.0e+00.
    labels = Attribute(_NAME, column_of(_NAME, [line.strip() for line in lines]))
    return [with_whole_numbers(labels)]
