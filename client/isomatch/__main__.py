"""``python -m isomatch``: the command line."""

from isomatch_command import main

main()
