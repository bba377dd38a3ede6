"""The gallery as a notebook: its text and its Python blocks as cells."""

import json
import re
from typing import Any, Final

_BLOCK: Final = re.compile(r"(?ms)^```python\n(.*?)\n```$")


def notebook(document: str) -> str:
    """Return a document in Markdown as a Jupyter notebook (format 4.5), without outputs.

    Parameters
    ----------
    document
        Its Python blocks become cells of code, the text between them cells of Markdown.
    """
    # re.split puts what a group matches between the rest: text, code, text, ...
    parts = _BLOCK.split(document)
    cells = [
        _cell(f"cell-{place}", part.strip("\n"), is_code=place % 2 == 1)
        for place, part in enumerate(parts)
        if part.strip()
    ]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    found = {
        "cells": cells,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(found, ensure_ascii=False, indent=1) + "\n"


def _cell(name: str, source: str, *, is_code: bool) -> dict[str, Any]:
    cell: dict[str, Any] = {
        "cell_type": "code" if is_code else "markdown",
        "id": name,
        "metadata": {},
        "source": source.splitlines(keepends=True),
    }
    return cell | ({"execution_count": None, "outputs": []} if is_code else {})
