"""The files that come with a mesh file, and how it refers to them."""

import posixpath
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from urllib.parse import unquote


@dataclass(frozen=True)
class Companions:
    """Files beside a mesh file.

    Parameters
    ----------
    names
        Their paths, with "/" between folders, none of which leads out of the common root.
    folder
        The mesh file's own folder, "" for the root.
    read
        Returns the bytes of one of `names`.
    """

    names: Sequence[str]
    folder: str
    read: Callable[[str], bytes]

    def find(self, reference: str) -> bytes | None:
        """Return the file that is meant, or None if it did not come.

        Parameters
        ----------
        reference
            As written in the mesh or material file: relative to it, absolute on the machine where
            it was written, with either slash, in either case. If no file has that path, the
            only one of that name, wherever it lies, is meant.
        """
        name = self._path(reference)
        return None if name is None else self.read(name)

    def _path(self, reference: str) -> str | None:
        written = unquote(reference).replace("\\", "/").strip().strip('"')
        for folder in (self.folder, ""):
            path = posixpath.normpath(posixpath.join(folder, written))
            if path in self._paths:
                return path
        last = posixpath.basename(written).casefold()
        alike = self._by_last_part.get(last, [])
        return alike[0] if len(alike) == 1 and last else None

    # A file may refer to others on every line.
    @cached_property
    def _paths(self) -> frozenset[str]:
        return frozenset(self.names)

    @cached_property
    def _by_last_part(self) -> Mapping[str, list[str]]:
        found: dict[str, list[str]] = {}
        for name in self.names:
            found.setdefault(posixpath.basename(name).casefold(), []).append(name)
        return found
