"""Protection of a service without API keys from web pages of other sites.

A browser sends what any page asks for to whatever service its user can reach, such as one on
``127.0.0.1``. A key stops that, as pages do not know it. Without keys two checks do:

- Names. A page whose host name is made to resolve to the service's address (DNS rebinding) is of
  the same origin to the browser. Its name is in ``Host``, where only names are accepted that
  nobody else can make resolve to this service.
- Origins. Other pages cannot read answers, but can send uploads. Browsers say in
  ``Sec-Fetch-Site``, or in ``Origin`` where the service has no TLS, which page has sent a request.
"""

import re
from collections.abc import Collection
from ipaddress import ip_address
from typing import Annotated, Final, TypeAlias

from pydantic import BeforeValidator
from pydantic_settings import NoDecode
from starlette.datastructures import Headers

from service.http.problems import ApiProblem, CrossSiteRequest, MisdirectedRequest

SAFE_METHODS: Final = ("GET", "HEAD", "OPTIONS")
"""Methods that change nothing (RFC 9110, section 9.2.1)."""

_HOST: Final = re.compile(r"(?:\[(?P<address>[^][]+)\]|(?P<name>[^][:@]+))(?::\d*)?")
_ORIGIN: Final = re.compile(r"(?P<scheme>https?)://(?P<host>.+)")
_NAME: Final = re.compile(r"[a-z0-9_-]+(\.[a-z0-9_-]+)*")
_LOCAL: Final = (".localhost", ".local", ".internal", ".test", ".home.arpa")
"""Domains that public DNS does not have, like names without a dot (RFC 6761, 6762 and 8375; ICANN
reserved ``.internal`` in 2024): containers and clusters name their services there."""

_DEFAULT_PORTS: Final = {"http": ":80", "https": ":443"}


def read_hosts(listing: object) -> object:
    """Read host names, separated by commas or white space.

    Raises
    ------
    ValueError
        One of them is no host name.
    """
    if not isinstance(listing, str):
        return listing
    names = tuple(_plain(name) for name in re.split(r"[,\s]+", listing) if name)
    for name in names:
        if not _NAME.fullmatch(name):
            raise ValueError(f"{name} is not a host name; write it without scheme, port and path")
    return names


Hosts: TypeAlias = Annotated[tuple[str, ...], NoDecode, BeforeValidator(read_hosts)]
"""Host names in lower case."""


def foreign_request(method: str, headers: Headers, hosts: Collection[str]) -> ApiProblem | None:
    """Return why a request without a key is refused, or None if it is not.

    Parameters
    ----------
    method
        Its method.
    headers
        Its headers.
    hosts
        Accepted host names in lower case, besides those that always are.
    """
    host = headers.get("host", "")
    # Browsers always send it.
    if host and not _accepted(host, hosts):
        return MisdirectedRequest(
            f"Without API keys this service does not answer under the name {host!r}; add the name"
            " to ISOMATCH_ALLOWED_HOSTS, or create API keys."
        )
    if method in SAFE_METHODS or _same_origin(headers, host, hosts):
        return None
    return CrossSiteRequest(
        "Without API keys this service takes no requests from web pages of other sites. If this"
        " page is the service's own, add its host name to ISOMATCH_ALLOWED_HOSTS, or create API"
        " keys."
    )


def _accepted(host: str, hosts: Collection[str]) -> bool:
    found = _HOST.fullmatch(host)
    if found is None:
        return False
    if found["address"]:
        return _is_address(found["address"])
    name = _plain(found["name"])
    local = "." not in name or name.endswith(_LOCAL)
    return local or _is_address(name) or name in hosts


def _same_origin(headers: Headers, host: str, hosts: Collection[str]) -> bool:
    site = headers.get("sec-fetch-site")
    if site is not None:
        return site in ("same-origin", "none")
    origin = headers.get("origin")
    if origin is None:
        return True
    found = _ORIGIN.fullmatch(origin.lower())
    if found is None:
        return False
    port = _DEFAULT_PORTS[found["scheme"]]
    if found["host"].removesuffix(port) == host.lower().removesuffix(port):
        return True
    # A proxy may have replaced `Host`.
    named = _HOST.fullmatch(found["host"])
    return named is not None and named["name"] in hosts


def _is_address(host: str) -> bool:
    try:
        ip_address(host)
    except ValueError:
        return False
    return True


def _plain(name: str) -> str:
    """Return a host name in lower case, without the dot of the root."""
    return name.lower().removesuffix(".")
