"""Commands, options and output of the command line, assembled in :mod:`isomatch.cli`."""

from isomatch._cli.batch_run import MatchFolder, run_batch
from isomatch._cli.examples import (
    COMPARE_EXAMPLES,
    LANDMARKS_EXAMPLES,
    MAPS_EXAMPLES,
    MATCH_EXAMPLES,
    REGISTER_EXAMPLES,
    TRANSFER_EXAMPLES,
)
from isomatch._cli.exit_codes import EXIT_CODES, Failures, connected, leave
from isomatch._cli.job_commands import jobs
from isomatch._cli.job_runs import echo_models, run
from isomatch._cli.landmark_command import landmarks
from isomatch._cli.maps_command import maps
from isomatch._cli.mcp_command import mcp
from isomatch._cli.options import (
    FORMATS,
    AsJson,
    FileFormat,
    MatchOutput,
    Meshes,
    Output,
    Picture,
    Quiet,
    SeenFrom,
    Source,
    Targets,
    Url,
    Wait,
    check_outputs,
    names_folder,
    names_prototype,
    output_given,
    output_option,
)
from isomatch._cli.parameter_table import takes
from isomatch._cli.prototype_commands import prototypes
from isomatch._cli.register_command import register
from isomatch._cli.serve import serve
from isomatch._cli.shape_commands import shapes
from isomatch._cli.transfer_command import transfer
from isomatch._cli.uploads import class_of, named_upload, uploaded, usable
from isomatch._cli.usage_errors import Commands

__all__ = [
    "COMPARE_EXAMPLES",
    "EXIT_CODES",
    "FORMATS",
    "LANDMARKS_EXAMPLES",
    "MAPS_EXAMPLES",
    "MATCH_EXAMPLES",
    "REGISTER_EXAMPLES",
    "TRANSFER_EXAMPLES",
    "AsJson",
    "Commands",
    "Failures",
    "FileFormat",
    "MatchFolder",
    "MatchOutput",
    "Meshes",
    "Output",
    "Picture",
    "Quiet",
    "SeenFrom",
    "Source",
    "Targets",
    "Url",
    "Wait",
    "check_outputs",
    "class_of",
    "connected",
    "echo_models",
    "jobs",
    "landmarks",
    "leave",
    "maps",
    "mcp",
    "named_upload",
    "names_folder",
    "names_prototype",
    "output_given",
    "output_option",
    "prototypes",
    "register",
    "run",
    "run_batch",
    "serve",
    "shapes",
    "takes",
    "transfer",
    "uploaded",
    "usable",
]
