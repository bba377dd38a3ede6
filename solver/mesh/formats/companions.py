"""Files that come with a mesh file, found by the references in it."""

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
        The mesh file's folder, "" for the root.
    read
        Returns the bytes of one of `names`.
    """

    names: Sequence[str]
    folder: str
    read: Callable[[str], bytes]

    def find(self, reference: str) -> bytes | None:
        """Return the bytes of the file that a reference names, or None if it is missing.

        Parameters
        ----------
        reference
            As written in the mesh or material file: relative to it, or absolute on the machine
            where it was written, with either slash. If no file has that path, the only one of that
            name, in any folder and either case, is taken.
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
