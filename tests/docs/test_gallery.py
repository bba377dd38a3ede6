"""The gallery's notebook has the code of the document, which is run, and nothing else."""

import ast
import json
import re

from demo.stack import ROOT
from tests.docs.blocks import blocks


def test_the_notebook_has_the_text_and_code_of_the_document() -> None:
    path = ROOT / "docs" / "gallery.md"
    notebook = json.loads((ROOT / "docs" / "gallery.ipynb").read_text())
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    cells = notebook["cells"]
    assert len({cell["id"] for cell in cells}) == len(cells)
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert [block.code.strip() for block in blocks(path)] == code
    for source in code:
        ast.parse(source)
    every = "\n".join("".join(cell["source"]) for cell in cells)
    document = re.sub(r"```python|```", "", path.read_text())
    assert every.split() == document.split()


def test_pictures_are_there() -> None:
    named = re.findall(r"!\[.+\]\((.+)\)", (ROOT / "docs" / "gallery.md").read_text())
    assert named
    for name in named:
        assert (ROOT / "docs" / name).read_bytes().startswith(b"\x89PNG")
