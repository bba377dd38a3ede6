"""Attributes written to any format, for tests."""

from collections.abc import Sequence

from solver.transfer import Attribute
from solver.transfer.files import WrittenSurface, write_csv, write_npz, write_surface


def write_attributes(
    attributes: Sequence[Attribute], file_type: str, surface: WrittenSurface
) -> bytes:
    if file_type == "npz":
        return write_npz(attributes)
    return write_csv(attributes) if file_type == "csv" else write_surface(surface, file_type)
