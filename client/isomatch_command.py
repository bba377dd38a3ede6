"""Entry point of the command line.

It stands outside the package, whose import takes most of the time of a start: until the commands
are there to answer an interrupt themselves, it ends the process at once, without a traceback.
"""

import signal


def main() -> None:
    """Import the command line and run it."""
    answer = signal.signal(signal.SIGINT, signal.SIG_DFL)
    from isomatch.cli import app

    signal.signal(signal.SIGINT, answer)
    app()


if __name__ == "__main__":
    main()
