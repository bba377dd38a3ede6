"""The restriction of tools to the files of one folder."""

import os
from pathlib import Path

import pytest
from isomatch._mcp.folder import Folder, RefusedPath


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    """A folder with a mesh, beside one with a secret."""
    root = tmp_path / "meshes"
    (root / "scans").mkdir(parents=True)
    (root / "a.off").write_text("OFF 0 0 0\n")
    (root / "scans" / "b.PLY").write_text("ply\n")
    secret = tmp_path / "secret"
    secret.mkdir()
    (secret / "key.txt").write_text("secret\n")
    return Folder.opened(root)


def test_files_in_the_folder_are_read(folder: Folder) -> None:
    for name in ("a.off", "./a.off", "scans/../a.off", str(folder.root / "a.off"), "scans/b.PLY"):
        path = folder.readable(name)
        assert path.is_relative_to(folder.root)
        assert path.is_file()
    (folder.root / "link.off").symlink_to("a.off")
    assert folder.readable("link.off") == folder.root / "a.off"


@pytest.mark.parametrize(
    "name",
    [
        "../secret/key.txt",
        "scans/../../secret/key.txt",
        "/etc/passwd",
        "/proc/self/environ",
        "out/key.txt",  # by a link to a folder
        "key.off",  # by a link to a file
        "hardly\0.off",
        "loop.off",
        "~/key.txt",
        "",
        ".",
        "scans",
        "missing.off",
        ".hidden.off",
        ".git/a.off",
        "note.md",
        "pipe.off",
    ],
)
def test_other_files_are_refused(folder: Folder, name: str) -> None:
    root = folder.root
    (root / "out").symlink_to(root.parent / "secret")
    (root / "key.off").symlink_to(root.parent / "secret" / "key.txt")
    (root / "loop.off").symlink_to("loop.off")
    (root / ".git").mkdir()
    for plain in (".hidden.off", ".git/a.off", "note.md"):
        (root / plain).write_text("x")
    os.mkfifo(root / "pipe.off")
    with pytest.raises(RefusedPath):
        folder.readable(name)


def test_a_link_to_another_ending_is_refused(folder: Folder) -> None:
    (folder.root / "note.md").write_text("x")
    (folder.root / "note.off").symlink_to("note.md")
    with pytest.raises(RefusedPath, match=r"note\.md"):
        folder.readable("note.off")


def test_new_files_are_written_in_the_folder_alone(folder: Folder) -> None:
    root = folder.root
    assert folder.writable("scans/match.json") == root / "scans" / "match.json"
    assert folder.name(root / "scans" / "match.json") == "scans/match.json"
    (root / "out").symlink_to(root.parent / "secret")
    (root / "dangling.json").symlink_to(root.parent / "secret" / "new.json")
    for name in (
        "a.off",
        "../match.json",
        "out/match.json",
        "dangling.json",
        "nowhere/match.json",
        ".match.json",
        "match.py",
        "match",
        str(root.parent / "match.json"),
    ):
        with pytest.raises(RefusedPath):
            folder.writable(name)
    folder.write_new(root / "match.json", b"{}")
    assert (root / "match.json").read_bytes() == b"{}"
    # A file, or a link to one, that came between check and writing.
    (root / "later.json").symlink_to(root.parent / "secret" / "new.json")
    for name in ("match.json", "later.json"):
        with pytest.raises(RefusedPath, match="nothing is overwritten"):
            folder.write_new(root / name, b"other")
    assert (root / "match.json").read_bytes() == b"{}"
    assert not (root.parent / "secret" / "new.json").exists()
    with pytest.raises(RefusedPath, match="nothing is overwritten"):
        folder.writable("match.json")


def test_a_home_or_the_whole_disk_has_to_be_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    for place in (tmp_path, Path("/")):
        monkeypatch.chdir(place)
        with pytest.raises(RefusedPath, match="--root"):
            Folder.opened(None)
        assert Folder.opened(place).root == place.resolve()
    (tmp_path / "meshes").mkdir()
    monkeypatch.chdir(tmp_path / "meshes")
    assert Folder.opened(None).root == (tmp_path / "meshes").resolve()
    with pytest.raises(RefusedPath, match="not a folder"):
        Folder.opened(tmp_path / "missing")
