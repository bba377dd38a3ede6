"""Every command and snippet of the documents is run, in order, against the running service."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from demo.stack import ROOT
from tests.docs.blocks import Block, Terminal, blocks, statements
from tests.docs.files import write_files

DOCUMENTS = [
    *sorted(ROOT.glob("*.md")),
    ROOT / "client" / "README.md",
    *sorted((ROOT / "docs").glob("*.md")),
]
LANGUAGES = {"", "sh", "python", "json"}
"""Blocks without a language are pictures, headers, or answers."""

BEFORE = {
    "docs/api.md": """
        import hashlib, hmac, time
        import isomatch
        secret, ended = "16 letters or more", {"id": "1", "kind": "match", "state": "failed"}
        ended |= {"created": "2026-01-01T00:00:00Z", "started": None, "ended": None, "error": None}
        body = json.dumps({"type": "job.ended", "job": ended | {"path": "/v1/jobs/1"}}).encode()
        now = str(int(time.time())).encode()
        digest = hmac.new(secret.encode(), now + b"." + body, hashlib.sha256).hexdigest()
        headers = {"Isomatch-Signature": f"t={now.decode()},v1={digest}"}
    """,
}
"""What a snippet takes for granted, by document."""

SAYS = {
    "client/README.md": ("points: ", "body.points", "urn:isomatch:problem:", "cancelled"),
    "docs/gallery.md": ("human-reaching: right foot", "mean average precision 1.0", "misfits them"),
}
"""What the snippets of a document print, among other things."""

LEAVES = {
    "README.md": ("match.png", "matrix.png"),
    "client/README.md": ("match.png", "match.json", "matrix.png"),
    "docs/collections.md": ("results/b.ply", "results/c.ply", "maps.npz"),
    "docs/prototypes.md": ("match.png", "human.npz"),
    "docs/transfer.md": ("parts_of_b.csv", "both.glb", "both.png"),
    "docs/templates.md": ("out/specimen1.ply", "out/mean.ply", "out/components.png"),
    "docs/landmarks.md": ("out/specimen2.mrk.json", "out/landmarks.csv", "out/landmarks.tps"),
}
"""Files that are there afterwards."""


WRITES = {
    "docs/collections.md": ("b.obj.ply", "c.off.ply"),
    "docs/gallery.md": (
        "walking-parts.ply",
        "walking-parts.csv",
        "human-reaching.mrk.json",
        "walking-dressed.glb",
        "walking-dressed.ply",
        "dissimilarities.csv",
        "dissimilarities.png",
        "person.npz",
    ),
}
"""Files that its snippets leave."""


def name_of(document: Path) -> str:
    return document.relative_to(ROOT).as_posix()


def in_language(document: Path, language: str) -> list[Block]:
    return [block for block in blocks(document) if block.language == language]


def with_code(language: str) -> list[Path]:
    return [document for document in DOCUMENTS if in_language(document, language)]


def test_no_block_is_passed_over() -> None:
    for document in DOCUMENTS:
        for block in blocks(document):
            assert block.language in LANGUAGES, f"{name_of(document)}:{block.line}"
    assert {"README.md", "client/README.md", "docs/api.md"} <= {name_of(d) for d in DOCUMENTS}
    assert {name_of(document) for document in with_code("python")} >= {*BEFORE, *SAYS, *WRITES}
    assert {name_of(document) for document in with_code("sh")} >= set(LEAVES)


@pytest.mark.parametrize("document", with_code("python"), ids=name_of)
def test_python(document: Path, url: str, tmp_path: Path) -> None:
    write_files(tmp_path, name_of(document))
    before = BEFORE.get(name_of(document), "")
    lines = ["import json, warnings", "warnings.simplefilter('error')"]
    lines += [line.strip() for line in before.splitlines()]
    program = "\n".join([*lines, *(block.code for block in in_language(document, "python"))])
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        timeout=500,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    for said in SAYS.get(name_of(document), ()):
        assert said in done.stdout
    for name in WRITES.get(name_of(document), ()):
        assert (tmp_path / name).stat().st_size > 100


@pytest.mark.parametrize("document", with_code("sh"), ids=name_of)
def test_commands(document: Path, url: str, tmp_path: Path) -> None:
    write_files(tmp_path, name_of(document))
    terminal = Terminal(tmp_path, url)
    for block in in_language(document, "sh"):
        if "curl " in block.code and shutil.which("curl") is None:
            pytest.skip("curl is not installed")
        for statement in statements(block.code):
            terminal.run(statement)
    for name in LEAVES.get(name_of(document), ()):
        assert (tmp_path / name).stat().st_size > 100


@pytest.mark.parametrize("document", with_code("json"), ids=name_of)
def test_json(document: Path) -> None:
    for block in in_language(document, "json"):
        json.loads(block.code)


def test_a_wrong_command_is_noticed(url: str, tmp_path: Path) -> None:
    terminal = Terminal(tmp_path, url)
    for wrong in (
        "make frobnicate",
        "isomatch frobnicate",
        "isomatch shapes --frobnicate",
        "curl -f http://127.0.0.1:8000/v1/frobnicate",
        "docker compose -f docker/frobnicate.yaml up",
        "python -m bench.pair --frobnicate",
        "curl http://127.0.0.1:8000/v1/jobs/d1ae…",
        'curl http://127.0.0.1:8000/v1/jobs  # → {"id": "d1ae…", …}',
    ):
        with pytest.raises(AssertionError):
            terminal.run(wrong)
    terminal.run("a=1")
    assert terminal.run("echo $a") == "1\n"
