"""Administration of tenants and their API keys: ``python -m service.admin``."""
