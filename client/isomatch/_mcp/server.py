"""The server: the tools over the standard input and output."""

import os
import signal
import threading
from importlib.metadata import version
from pathlib import Path
from typing import Final

import anyio
from mcp.server.mcpserver import MCPServer
from mcp_types import ToolAnnotations

from isomatch._clients import AsyncClient
from isomatch._mcp.folder import Folder
from isomatch._mcp.strict_tool import StrictTool
from isomatch._mcp.tools import Tools

INSTRUCTIONS: Final = (
    "Correspondence of non-rigid shapes: which point of one surface is which point of another."
    " Files are named relative to {root}; no other files can be read or written, and none is"
    " overwritten. Typical: `match` with `dense`, look at `confidence` and `picture`, then"
    " `transfer`. A low energy and a certificate do not say that an answer is right; `confidence`"
    " says how probable that is."
)


ENDING: Final = 1.5
"""Seconds from SIGTERM to the end: MCP clients kill what has not ended after two."""


def server(client: AsyncClient, folder: Folder) -> MCPServer[None]:
    """Return a server of the tools, for any transport."""
    tools = Tools(client, folder)
    # Nothing is overwritten or deleted, and the same upload again changes nothing.
    harmless = ToolAnnotations(read_only_hint=False, destructive_hint=False)
    writing = (tools.upload, tools.match, tools.compare, tools.transfer)
    return MCPServer(
        "isomatch",
        title="isomatch",
        version=version("isomatch"),
        instructions=INSTRUCTIONS.format(root=folder.root),
        log_level="WARNING",
        tools=[
            *(StrictTool.of(tool, harmless) for tool in writing),
            StrictTool.of(tools.picture, ToolAnnotations(read_only_hint=True)),
        ],
    )


def serve(url: str | None, root: Path | None) -> None:
    """Serve on the standard input and output until the input ends.

    Parameters
    ----------
    url
        Address of the service; None for that of the environment.
    root
        Folder of the files; None for the current one.

    Raises
    ------
    RefusedPath, ValueError
        The folder or the address cannot be used.
    """
    folder = Folder.opened(root)

    async def run() -> None:
        async with AsyncClient(url) as client, anyio.create_task_group() as group:
            if os.name == "posix":
                group.start_soon(_end_on_sigterm, group.cancel_scope)
            await server(client, folder).run_stdio_async()
            group.cancel_scope.cancel()

    anyio.run(run)


async def _end_on_sigterm(scope: anyio.CancelScope) -> None:
    """Cancel the running calls, and so their jobs, when the process is asked to end."""
    with anyio.open_signal_receiver(signal.SIGTERM) as signals:
        async for _ in signals:
            # The thread that reads the standard input ends with the input alone.
            leaving = threading.Timer(ENDING, os._exit, (128 + signal.SIGTERM,))
            leaving.daemon = True
            leaving.start()
            scope.cancel()
