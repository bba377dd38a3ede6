"""ZIP archives: one mesh file and the files that it refers to, materials and images.

Nothing is unpacked to disk. Only members that the mesh refers to are read, never more of one than
the archive's directory promises, nor of all than `MOST_BYTES` and the compression ratio allow.
"""

import contextlib
import io
import posixpath
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field

from solver.errors import MeshError
from solver.mesh.formats.companions import Companions
from solver.mesh.formats.readers import FORMATS, TABLES, WITH_COMPANIONS
from solver.mesh.repair import TriangleSoup

MOST_MEMBERS = 1000
"""Files in an archive."""

MOST_BYTES = 512 * 2**20
"""Bytes read of an archive, uncompressed; a ZIP bomb promises or delivers more."""

_MOST_RATIO = 24
"""Uncompressed bytes per byte of an archive; meshes have about five, very regular ones ten."""

_ALWAYS_ALLOWED = 8 * 2**20
"""Uncompressed bytes that an archive may have at any ratio: tiny files compress even better."""

_SHAPES = tuple(ending for ending in FORMATS if ending not in TABLES)
"""Endings of mesh files in an archive."""

_ENCRYPTED, _UTF8 = 0x1, 0x800
"""Flags of a member."""


def read_zip(data: bytes) -> TriangleSoup:
    """Read the mesh file in a ZIP archive.

    Parameters
    ----------
    data
        Bytes of the archive. It holds one mesh file and the files that it refers to: for OBJ
        its material files and their images, for glTF its buffers and images. Other files are
        ignored, also points as .txt and .csv, which may be notes and tables.

    Returns
    -------
    TriangleSoup
        As of the reader of the mesh file's format.

    Raises
    ------
    MeshError
        The archive is damaged, encrypted, too large, or has paths that lead out of it; it has no
        mesh file or several; the mesh file cannot be read, or a file it refers to is missing.
    """
    archive = _Archive.opened(data)
    name = archive.mesh_name()
    ending, contents = _extension(name), archive.read(name)
    if ending not in WITH_COMPANIONS:
        return FORMATS[ending](contents)
    companions = Companions(tuple(archive.members), posixpath.dirname(name), archive.read)
    return WITH_COMPANIONS[ending](contents, companions)


def mesh_in_zip(data: bytes) -> tuple[str, bytes]:
    """Return the format and the bytes of the mesh file in a ZIP archive.

    Raises
    ------
    MeshError
        As :func:`read_zip`, but for what is wrong with the mesh file.
    """
    archive = _Archive.opened(data)
    name = archive.mesh_name()
    return _extension(name), archive.read(name)


@dataclass
class _Archive:
    file: zipfile.ZipFile
    members: Mapping[str, zipfile.ZipInfo]
    most: int
    left: int
    seen: dict[str, bytes] = field(default_factory=dict)

    @staticmethod
    def opened(data: bytes) -> "_Archive":
        try:
            file = zipfile.ZipFile(io.BytesIO(data))
        except MemoryError:
            raise
        except Exception as error:  # a damaged directory makes zipfile raise anything
            raise MeshError(f"not a ZIP archive, or it is damaged or cut off: {error}") from error
        members = [(_path(member), member) for member in file.infolist()]
        # A folder ends with a slash; a file without a name cannot be referred to.
        members = [(name, member) for name, member in members if name and name[-1] != "/"]
        names = [name for name, _ in members]
        if len(names) > MOST_MEMBERS:
            raise MeshError(
                f"the archive has more than {MOST_MEMBERS} files; pack only those of the shape"
            )
        for name in names:
            if posixpath.isabs(name) or ".." in name.split("/"):
                raise MeshError(
                    f"the path of {name[:100]!r} leads out of the archive; pack it again without"
                )
        if len(set(names)) < len(names):
            raise MeshError("the archive has two files of the same name; pack it again")
        # macOS packs metadata of its own beside the files, as ._NAME.
        own = {
            name: member
            for name, member in members
            if not posixpath.basename(name).startswith("._")
        }
        most = min(_MOST_RATIO * len(data) + _ALWAYS_ALLOWED, MOST_BYTES)
        return _Archive(file, own, most, most)

    def mesh_name(self) -> str:
        meshes = [name for name in self.members if _extension(name) in _SHAPES]
        if not meshes:
            known = ", ".join("." + ending for ending in _SHAPES)
            raise MeshError(f"the archive has no mesh file; one ending in {known} is needed")
        if len(meshes) > 1:
            listed = ", ".join(name[:100] for name in meshes[:5])
            raise MeshError(
                f"the archive has {len(meshes)} mesh files ({listed}); upload each shape in "
                "an archive of its own"
            )
        return meshes[0]

    def read(self, name: str) -> bytes:
        if name in self.seen:
            return self.seen[name]
        member = self.members[name]
        if member.flag_bits & _ENCRYPTED:
            raise MeshError(f"{name[:100]} in the archive is encrypted; pack it without a password")
        if member.file_size > self.left:
            raise MeshError(self._too_large())
        try:
            with self.file.open(member) as stream:
                contents = stream.read(member.file_size + 1)
        except MemoryError:
            raise
        except Exception as error:  # zipfile and zlib raise a dozen kinds for a damaged member
            raise MeshError(
                f"{name[:100]} in the archive cannot be unpacked; it is damaged ({error})"
            ) from error
        if len(contents) != member.file_size:
            raise MeshError(
                f"{name[:100]} in the archive does not have the size it declares; it is damaged"
            )
        self.left -= len(contents)
        self.seen[name] = contents
        return contents

    def _too_large(self) -> str:
        if self.most == MOST_BYTES:
            return (
                f"the archive is larger than {MOST_BYTES >> 20} MiB when unpacked; simplify the "
                "mesh, or save its images smaller"
            )
        return (
            f"the archive is larger than {self.most >> 20} MiB when unpacked, which is far too "
            "much for its size; upload the mesh file unpacked, and images as PNG or JPEG"
        )


def _path(member: zipfile.ZipInfo) -> str:
    """Path of a member, with "/" between folders.

    Some programs write backslashes, and some write UTF-8 without saying so.
    """
    name = member.filename
    if not member.flag_bits & _UTF8:
        with contextlib.suppress(UnicodeError):
            name = name.encode("cp437").decode("utf-8")
    return name.replace("\\", "/")


def _extension(name: str) -> str:
    return posixpath.splitext(name)[1].removeprefix(".").lower()
