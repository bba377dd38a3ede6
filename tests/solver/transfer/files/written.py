"""Attributes written to any format, for tests."""

from collections.abc import Sequence

from solver.transfer import Attribute
from solver.transfer.files import WrittenSurface, write_csv, write_npz, write_surface


def write_attributes(
    attributes: Sequence[Attribute], file_type: str, surface: WrittenSurface
) -> bytes:
    if file_type == "npz":
        return write_npz(attributes)
    if file_type in ("seg", "txt"):
        return "\n".join(map(str, attributes[0].values.tolist())).encode()
    return write_csv(attributes) if file_type == "csv" else write_surface(surface, file_type)
