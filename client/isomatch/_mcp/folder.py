"""The folder whose files tools may read and write, and no others.

Names come from a language model, which may have been misled by what it read. So a tool uploads
nothing but meshes and attributes, from this folder alone, and overwrites nothing.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from isomatch._operations.results import ENDINGS

READABLE: Final = frozenset(
    "off obj ply stl glb gltf zip xyz txt csv las laz npz seg".split()  # noqa: SIM905 - as in texts
)
"""Endings of files that may be uploaded: meshes, points and attributes."""


class RefusedPath(ValueError):
    """A path that a tool may not read or write; the message gives the reason."""


@dataclass(frozen=True)
class Folder:
    """A folder that tools are restricted to.

    Attributes
    ----------
    root
        Its real path, without symbolic links.
    """

    root: Path

    @classmethod
    def opened(cls, given: Path | None) -> "Folder":
        """Return the folder at a path, or the current one.

        Raises
        ------
        RefusedPath
            It is no folder; or none is given, and the current one is a home directory or that of
            the file system, where desktop programs start what they run.
        """
        root = (Path.cwd() if given is None else given).resolve()
        if not root.is_dir():
            raise RefusedPath(f"{str(given)!r} is not a folder")
        if given is None and root in (Path(root.anchor), Path.home().resolve()):
            raise RefusedPath(
                f"the current directory is {root}: all files in it could be uploaded; name the"
                " folder of the meshes with --root"
            )
        return cls(root)

    def readable(self, name: str) -> Path:
        """Return the real path of a file to upload.

        Raises
        ------
        RefusedPath
            It is outside the folder, also by a symbolic link, hidden, no file, or no mesh or
            attributes by its ending.
        """
        path = self._inside(name)
        if not path.is_file():
            raise RefusedPath(f"there is no file {name!r} in {self.root}")
        _check_ending(path, READABLE)
        return path

    def writable(self, name: str) -> Path:
        """Return the real path of a file to write, which does not exist yet.

        Raises
        ------
        RefusedPath
            It is outside the folder, also by a symbolic link, hidden, exists, its folder does not,
            or its ending is that of no result.
        """
        path = self._inside(name)
        if path.exists():
            raise RefusedPath(f"{name!r} exists, and nothing is overwritten; choose another name")
        if not path.parent.is_dir():
            raise RefusedPath(f"there is no folder {str(path.parent.relative_to(self.root))!r}")
        _check_ending(path, ENDINGS)
        return path

    def write_new(self, path: Path, content: bytes) -> None:
        """Write a file that :meth:`writable` returned; minutes may have passed since.

        Raises
        ------
        RefusedPath
            It exists by now.
        """
        try:
            with path.open("xb") as file:
                file.write(content)
        except FileExistsError as error:
            raise RefusedPath(
                f"{self.name(path)!r} was made meanwhile, and nothing is overwritten"
            ) from error

    def name(self, path: Path) -> str:
        """Return a path in the folder as a name relative to it."""
        return path.relative_to(self.root).as_posix()

    def _inside(self, name: str) -> Path:
        try:
            path = (self.root / name).resolve()
        except (OSError, RuntimeError, ValueError) as error:  # loops of links, null characters
            raise RefusedPath(f"{name!r} is not the name of a file") from error
        if not path.is_relative_to(self.root):
            raise RefusedPath(
                f"{name!r} is outside {self.root}, the folder that files are read from and written"
                " to; `isomatch mcp --root` chooses another"
            )
        if any(part.startswith(".") for part in path.relative_to(self.root).parts):
            raise RefusedPath(f"{name!r} is hidden: files and folders that begin with '.' are")
        return path


def _check_ending(path: Path, endings: frozenset[str] | tuple[str, ...]) -> None:
    if path.suffix.lower().removeprefix(".") not in endings:
        raise RefusedPath(f"{path.name!r} ends in none of {', '.join(sorted(endings))}")
