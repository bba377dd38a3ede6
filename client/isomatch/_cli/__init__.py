"""The command line's commands, options and output; :mod:`isomatch.cli` puts them together."""

from isomatch._cli.examples import COMPARE_EXAMPLES, MATCH_EXAMPLES
from isomatch._cli.job_commands import jobs
from isomatch._cli.options import (
    FORMATS,
    AsJson,
    Mesh,
    Meshes,
    Output,
    Picture,
    Quiet,
    Source,
    Url,
    Wait,
    names_prototype,
)
from isomatch._cli.parameter_table import takes
from isomatch._cli.prototype_commands import prototypes
from isomatch._cli.serve import serve
from isomatch._cli.shell import (
    EXIT_CODES,
    class_of,
    connected,
    echo_models,
    leave,
    named_upload,
    run,
    shape_name,
    uploaded,
)

__all__ = [
    "COMPARE_EXAMPLES",
    "EXIT_CODES",
    "FORMATS",
    "MATCH_EXAMPLES",
    "AsJson",
    "Mesh",
    "Meshes",
    "Output",
    "Picture",
    "Quiet",
    "Source",
    "Url",
    "Wait",
    "class_of",
    "connected",
    "echo_models",
    "jobs",
    "leave",
    "named_upload",
    "names_prototype",
    "prototypes",
    "run",
    "serve",
    "shape_name",
    "takes",
    "uploaded",
]
