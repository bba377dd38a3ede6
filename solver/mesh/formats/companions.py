"""Files that come with a mesh file, found by the references in it."""

import posixpath
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from unicodedata import normalize
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
        # In glTF and some OBJ "%20" is a blank; a file may have it in its name, too.
        written = [_cleaned(one) for one in dict.fromkeys((reference, unquote(reference)))]
        for one in written:
            for folder in (_composed(self.folder), ""):
                path = posixpath.normpath(posixpath.join(folder, one))
                if path in self._paths:
                    return self._paths[path]
        for one in written:
            last = posixpath.basename(one).casefold()
            alike = self._by_last_part.get(last, [])
            if len(alike) == 1 and last:
                return alike[0]
        return None

    # A file may refer to others on every line.
    @cached_property
    def _paths(self) -> Mapping[str, str]:
        return {_composed(name): name for name in self.names}

    @cached_property
    def _by_last_part(self) -> Mapping[str, list[str]]:
        found: dict[str, list[str]] = {}
        for name in self.names:
            last = posixpath.basename(_composed(name)).casefold()
            found.setdefault(last, []).append(name)
        return found


def _cleaned(reference: str) -> str:
    return _composed(reference).replace("\\", "/").strip().strip('"')


def _composed(name: str) -> str:
    """Return a name with its accents as part of their letters (NFC): macOS keeps them apart."""
    return normalize("NFC", name)
