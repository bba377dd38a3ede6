"""The page at the root: where results are looked at; static files, and nothing is computed."""
