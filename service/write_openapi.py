"""Write the OpenAPI document: ``python -m service.write_openapi PATH``."""

import argparse
import sys
from pathlib import Path

from service.app import create_app
from service.http.openapi import text
from service.settings import Settings


def main() -> int:
    """Write the document to the path given on the command line."""
    parser = argparse.ArgumentParser(prog="python -m service.write_openapi", description=__doc__)
    parser.add_argument("path", type=Path)
    path: Path = parser.parse_args().path
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text(create_app(Settings())), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
