"""``python -m service``: run the service until it is interrupted."""

import argparse
import asyncio
import os
import sys

from pydantic import ValidationError

from broker.environment import misspelt_variables, setting_errors
from broker.telemetry import configure_logging, logger
from service.settings import Settings
from service.standalone import StartError, serve


def main() -> int:
    """Run the service and return its exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m service", description="Run isomatch; settings are read from ISOMATCH_*."
    )
    parser.add_argument("--host", help="address to listen on (127.0.0.1)")
    parser.add_argument("--port", type=int, help="port to listen on, 0 for a free one (8000)")
    options = {k: v for k, v in vars(parser.parse_args()).items() if v is not None}
    try:
        settings = Settings(**options)
        configure_logging(settings.log_level, process="api")
        for name, meant in misspelt_variables(os.environ, Settings).items():
            logger("isomatch.service").warning("unknown setting", variable=name, meant=meant)
        asyncio.run(serve(settings))
    except ValidationError as error:
        for complaint in setting_errors(error):
            print(f"isomatch: {complaint}", file=sys.stderr)
        return 2
    except StartError as error:
        print(f"isomatch: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
