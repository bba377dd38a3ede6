"""The files of the page, read and compressed on first use."""

import gzip
import hashlib
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path, PurePosixPath
from typing import Final

from service.http import weak_etag

STATIC: Final = Path(__file__).with_name("static")
PLOTLY: Final = "plotly.min.js"
"""plotly.js, from the data of the Python package plotly, whose Python code is not imported."""

_MODULES: Final = b"<!-- modules -->"
"""Stands in the page for links to its modules."""

MEDIA_TYPES: Final = {
    ".css": "text/css",
    ".html": "text/html",
    ".js": "text/javascript",
    ".off": "text/plain",
    ".svg": "image/svg+xml",
}


@dataclass(frozen=True)
class PageFile:
    """A file of the page.

    Parameters
    ----------
    packed
        Its content in gzip.
    media_type
        Its media type.
    etag
        Entity tag, a digest of the content.
    """

    packed: bytes
    media_type: str
    etag: str


def page_file(path: PurePosixPath) -> PageFile | None:
    """Return a file of the page, or None if there is none at this path below ``/page``."""
    found = _paths().get(str(path))
    return None if found is None else _read(found)


@cache
def _preloads() -> bytes:
    """Links to all modules: otherwise a browser finds each when it has read another."""
    modules = sorted(path.name for path in STATIC.glob("*.js"))
    links = (f'<link rel="modulepreload" href="/page/{name}">' for name in modules)
    return "\n".join(links).encode()


@cache
def _paths() -> dict[str, Path]:
    files = (path for path in STATIC.rglob("*") if path.suffix in MEDIA_TYPES)
    return {path.relative_to(STATIC).as_posix(): path for path in files} | _plotly()


def _plotly() -> dict[str, Path]:
    # Without the package the page works, but draws nothing.
    package = find_spec("plotly")
    places = () if package is None else package.submodule_search_locations or ()
    files = (Path(place, "package_data", PLOTLY) for place in places)
    return {file.name: file for file in files}


@cache
def _read(path: Path) -> PageFile:
    data = path.read_bytes().replace(_MODULES, _preloads())
    return PageFile(
        packed=gzip.compress(data, compresslevel=6, mtime=0),
        media_type=MEDIA_TYPES[path.suffix],
        etag=weak_etag(hashlib.sha256(data).hexdigest()[:20]),
    )
