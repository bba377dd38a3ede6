"""Which service is meant, and the key it is asked with: arguments, or the environment."""

import os
from typing import Final

DEFAULT_URL: Final = "http://127.0.0.1:8000"
URL_VARIABLE: Final = "ISOMATCH_URL"
KEY_VARIABLE: Final = "ISOMATCH_API_KEY"


def address(given: str | None) -> str:
    """Return the address of the service.

    Raises
    ------
    ValueError
        It is not an http(s) address.
    """
    base_url = given or os.environ.get(URL_VARIABLE) or DEFAULT_URL
    if not base_url.startswith(("http://", "https://")):
        raise ValueError(
            f"the service's address must begin with http:// or https://, not {base_url!r}"
        )
    return base_url


def key(given: str | None) -> str | None:
    """Return the API key, if there is one.

    Raises
    ------
    ValueError
        It cannot be sent.
    """
    api_key = given or os.environ.get(KEY_VARIABLE) or None
    if api_key is not None and not (api_key.isascii() and api_key.isprintable()):
        raise ValueError("the API key must be printable ASCII")
    return api_key
