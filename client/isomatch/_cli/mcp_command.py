"""``isomatch mcp``: tools for programs with a language model."""

from pathlib import Path
from typing import Annotated

import typer

from isomatch._cli.exit_codes import leave
from isomatch._cli.options import Url
from isomatch._errors import MissingExtra
from isomatch._http import DEFAULT_URL

Root = Annotated[
    Path | None,
    typer.Option(
        help="Folder of the meshes, the current one by default: no other files are read or written."
    ),
]


def mcp(root: Root = None, url: Url = DEFAULT_URL) -> None:
    """Serve upload, match, compare, transfer and picture by the Model Context Protocol.

    Programs with a language model start this command and talk with it on its standard input and
    output. It needs the extra "mcp" of this package.
    """
    try:
        # Imports half a second of packages, which other commands do not need.
        from isomatch._mcp import serve
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] not in ("mcp", "mcp_types"):
            raise
        leave(MissingExtra("mcp", "mcp"))
    try:
        serve(url, root)
    except (OSError, ValueError) as error:
        leave(error)
