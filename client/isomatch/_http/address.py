"""Address of the service and API key, from arguments or from the environment."""

import os
from typing import Final

import httpx2

DEFAULT_URL: Final = "http://127.0.0.1:8000"
URL_VARIABLE: Final = "ISOMATCH_URL"
KEY_VARIABLE: Final = "ISOMATCH_API_KEY"


def url_or_default(given: str | None) -> str:
    """Return the address of the service.

    Raises
    ------
    TypeError
        It is no text.
    ValueError
        It is not an http(s) address.
    """
    _check_text("base_url", given)
    url = given or os.environ.get(URL_VARIABLE) or DEFAULT_URL
    if not url.startswith(("http://", "https://")):
        raise ValueError(f"the service's address must begin with http:// or https://, not {url!r}")
    try:
        address = httpx2.URL(url)
    except httpx2.InvalidURL as error:
        raise ValueError(f"the service's address {url!r} cannot be used: {error}") from error
    if not address.host or any(map(str.isspace, url)):
        raise ValueError(f"the service's address {url!r} is none such as {DEFAULT_URL}")
    if address.port is not None and not 0 < address.port < 65536:
        raise ValueError(f"the service's address {url!r} has no port from 1 to 65535")
    return url


def api_key_or_default(given: str | None) -> str | None:
    """Return the API key, or None without one.

    Raises
    ------
    TypeError
        It is no text.
    ValueError
        It cannot be sent in a header.
    """
    _check_text("api_key", given)
    api_key = given or os.environ.get(KEY_VARIABLE) or None
    if api_key is not None and not (api_key.isascii() and api_key.isprintable()):
        raise ValueError("the API key must be printable ASCII")
    return api_key


def _check_text(name: str, given: str | None) -> None:
    if given is not None and not isinstance(given, str):
        raise TypeError(f"{name} must be a text, not {type(given).__name__}")
