"""Names of downloaded files (RFC 6266)."""

import re
from typing import Final
from urllib.parse import quote

_UNSAFE: Final = re.compile(r'[\x00-\x1f\x7f-\x9f\ud800-\udfff/\\:*?"<>|]')
"""Characters that the name of a file cannot have on every system."""

_UNQUOTED: Final = re.compile(r"[^ -~]|%")
"""Characters that not every program reads in a quoted name."""

LONGEST: Final = 200
"""Characters of a name besides its ending."""


def attachment(stem: str, ending: str) -> dict[str, str]:
    """Return the header with which an answer is saved as a file.

    Parameters
    ----------
    stem
        Name of the file; characters that file names cannot have become underscores.
    ending
        Its ending, without the dot.
    """
    name = f"{_UNSAFE.sub('_', stem)[:LONGEST].strip(' .') or 'file'}.{ending}"
    plain = _UNQUOTED.sub("_", name)
    value = f'attachment; filename="{plain}"'
    if plain != name:
        value += f"; filename*=UTF-8''{quote(name, safe='')}"
    return {"Content-Disposition": value}
