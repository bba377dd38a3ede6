"""Release of the service."""

from typing import Final

VERSION: Final = "0.1.0"
"""Version of this release, as in ``pyproject.toml``; packages need not be installed to run it."""
