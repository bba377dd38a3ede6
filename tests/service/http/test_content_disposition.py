"""Names of downloaded files, as clients read them from the header."""

from email.message import Message

import pytest

from service.http import attachment


def read(header: str) -> str | None:
    message = Message()
    message["Content-Disposition"] = header
    return message.get_filename()


@pytest.mark.parametrize(
    ("stem", "plain", "full"),
    [
        ("cat0-to-lion0", "cat0-to-lion0.ply", "cat0-to-lion0.ply"),
        ("Fuß", "Fu_.ply", "Fuß.ply"),
        ("100%", "100_.ply", "100%.ply"),
        ("猫-to-🦁", "_-to-_.ply", "猫-to-🦁.ply"),
        ('a"; filename="b', "a_; filename=_b.ply", "a_; filename=_b.ply"),
        ("../etc/passwd\r\n", "_etc_passwd__.ply", "_etc_passwd__.ply"),
        ("...", "file.ply", "file.ply"),
        ("x" * 500, "x" * 200 + ".ply", "x" * 200 + ".ply"),
    ],
)
def test_names_are_read_as_they_were_given(stem: str, plain: str, full: str) -> None:
    (header,) = attachment(stem, "ply").values()
    header.encode("ascii")
    assert f'filename="{plain}"' in header
    assert read(header.replace(f'filename="{plain}"; ', "")) == full
