"""Generated files are those that the declarations give."""

import pytest

from codegen.files import ROOT, contract_files, derived_files


@pytest.mark.parametrize("files", [contract_files, derived_files], ids=["contracts", "derived"])
def test_generated_files_follow_the_declarations(files: object) -> None:
    assert callable(files)
    changed = [
        path for path, text in files().items() if (ROOT / path).read_text(encoding="utf-8") != text
    ]
    assert not changed, "the declarations have changed; run `make generate`"
