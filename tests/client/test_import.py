"""What the package imports."""

import subprocess
import sys


def test_the_package_imports_nothing_of_the_command_line() -> None:
    check = "import isomatch, sys; print(sys.modules.keys() & {'rich', 'typer'})"
    done = subprocess.run(
        [sys.executable, "-c", check], capture_output=True, text=True, check=False
    )
    assert done.stdout == "set()\n"
