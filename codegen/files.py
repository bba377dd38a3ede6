"""The generated files and their contents."""

from pathlib import Path
from typing import Final

from codegen.contracts import solver_options, structure_choices
from codegen.python_source import formatted

ROOT: Final = Path(__file__).resolve().parents[1]


def contract_files() -> dict[str, str]:
    """Return the contracts of the solver's options, by path from the root of the repository."""
    return {
        "broker/contracts/structure_choices.py": formatted(structure_choices()),
        "broker/contracts/solver_options.py": formatted(solver_options()),
    }


def derived_files() -> dict[str, str]:
    """Return the files that follow from all contracts, by path from the root of the repository."""
    # Imported late: while the contracts are being generated, there may be none to import.
    from codegen.blocking_client import blocking_client
    from codegen.client import command_line_options, parameter_types
    from codegen.described import JOBS, described
    from codegen.documents import DOCUMENTS, document
    from codegen.notebook import notebook
    from codegen.page import form_parameters
    from service.app import create_app
    from service.http.openapi import text
    from service.settings import Settings

    jobs = {job.name: described(job.model) for job in JOBS}
    return {
        "openapi/openapi.json": text(create_app(Settings())),
        "client/isomatch/_models/parameters.py": formatted(parameter_types(jobs)),
        "client/isomatch/_cli/parameter_options.py": formatted(command_line_options(jobs)),
        "service/page/static/parameters.js": form_parameters(jobs),
        "docs/gallery.ipynb": notebook((ROOT / "docs/gallery.md").read_text(encoding="utf-8")),
        **blocking_client(ROOT),
        **{path: document((ROOT / path).read_text(encoding="utf-8"), jobs) for path in DOCUMENTS},
    }
