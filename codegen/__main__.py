"""Write all generated files: ``python -m codegen``, or ``make generate``."""

import subprocess
import sys

from codegen.files import ROOT, contract_files, derived_files


def main() -> int:
    """Write the contracts first: all other files are derived from them, in a new interpreter."""
    files = derived_files() if sys.argv[1:] == ["derived"] else contract_files()
    for path, text in files.items():
        (ROOT / path).write_text(text, encoding="utf-8")
    if sys.argv[1:] == ["derived"]:
        return 0
    return subprocess.run([sys.executable, "-m", "codegen", "derived"], cwd=ROOT).returncode


if __name__ == "__main__":
    sys.exit(main())
