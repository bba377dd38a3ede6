"""Tenants: who owns shapes, jobs and prototypes."""

import re
from typing import Final

DEFAULT_TENANT: Final = "default"
"""The tenant of a service without API keys, and of keys that name none."""

TENANT_NAME: Final = re.compile(r"[A-Za-z0-9._-]{1,64}")
"""Names of tenants; no key in Redis, and no path of a blob, can have two meanings with them."""
