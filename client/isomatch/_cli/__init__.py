"""Commands, options and output of the command line, assembled in :mod:`isomatch.cli`."""
