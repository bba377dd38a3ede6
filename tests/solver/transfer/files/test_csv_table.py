"""Cells of tables: which are numbers, and that long ones are read in linear time."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from solver.errors import TransferError
from solver.transfer.files.csv_table import column_of

LONG = "1" * 1_000_000


def number(cell: str) -> float | None:
    """Return what Python reads, None for text."""
    try:
        return float(cell)
    except ValueError:
        return None


@given(st.text("017+-.eE", min_size=1, max_size=10))
@example("1.")
@example(".1")
@example("1.e1")
@example(".")
@example("1e")
@example("1.1.1")
@example("9e999")
def test_numbers_are_those_that_python_reads(cell: str) -> None:
    value = number(cell)
    if value is not None and math.isinf(value):
        with pytest.raises(TransferError, match="infinite numbers"):
            column_of("a", [cell])
        return
    (found,) = column_of("a", [cell]).tolist()
    assert found == (cell if value is None else value)


@pytest.mark.timeout(60)
@pytest.mark.parametrize(
    "cell",
    [f"{LONG}x", f"{LONG}.{LONG}x", f".{LONG}x", f"1e{LONG}x"],
    ids=["whole", "decimal", "fraction", "exponent"],
)
def test_a_long_cell_is_read_in_linear_time(cell: str) -> None:
    """In quadratic time it took an hour; the timeout is far above what a slow machine takes."""
    assert column_of("a", [cell]).tolist() == [cell]
