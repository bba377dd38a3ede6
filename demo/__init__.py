"""The demo: ``python -m demo`` matches two generated figures with the whole stack."""
