"""``isomatch mcp``: a Model Context Protocol server over the SDK; needs the extra ``mcp``."""

from isomatch._mcp.folder import Folder
from isomatch._mcp.server import serve

__all__ = ["Folder", "serve"]
