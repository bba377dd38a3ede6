"""`python -m demo`: the whole of isomatch on two generated figures, in one command."""
