"""Addresses that webhooks may be sent to: public ones, and networks that the operator allows."""

import socket
from ipaddress import IPv4Address, IPv4Network, IPv6Address, IPv6Network, ip_address, ip_network
from typing import Final, TypeAlias

Address: TypeAlias = IPv4Address | IPv6Address
Network: TypeAlias = IPv4Network | IPv6Network

_TRANSLATED: Final = IPv6Network("64:ff9b::/96")
"""IPv4-embedded IPv6 addresses of NAT64 networks (RFC 6052)."""

_REFUSED: Final[tuple[Network, ...]] = (
    # Azure WireServer: a public address that serves secrets to virtual machines.
    IPv4Network("168.63.129.16/32"),
    # Private too, which not every version of Python knows.
    IPv4Network("192.0.0.0/24"),
    IPv6Network("fec0::/10"),
    # 6to4 and Teredo lead to the embedded IPv4 address; local NAT64 (RFC 8215).
    IPv6Network("2002::/16"),
    IPv6Network("2001::/32"),
    IPv6Network("64:ff9b:1::/48"),
)


def permitted(address: str, allowed: tuple[Network, ...] = ()) -> bool:
    """Return whether an address is public, or in a network that is allowed explicitly.

    Private, loopback, link-local (cloud metadata services), shared, multicast and reserved
    addresses are not public, nor IPv6 addresses that embed such an IPv4 address.

    Parameters
    ----------
    address
        IPv4 or IPv6 address.
    allowed
        Networks whose addresses are permitted, public or not.
    """
    parsed = _plain(ip_address(address.partition("%")[0]))
    if any(parsed in network for network in allowed if network.version == parsed.version):
        return True
    if any(parsed in network for network in _REFUSED if network.version == parsed.version):
        return False
    return parsed.is_global and not parsed.is_multicast and not parsed.is_reserved


def literal_address(host: str) -> str | None:
    """Return the address that a host's name denotes without DNS, None for other names.

    ``127.1``, ``0x7f000001`` and ``2130706433`` all denote 127.0.0.1 to ``connect``.
    """
    name = host.rstrip(".").lower()
    if name == "localhost" or name.endswith(".localhost"):
        return "127.0.0.1"
    try:
        return str(ip_address(name.partition("%")[0]))
    except ValueError:
        pass
    try:
        return socket.inet_ntoa(socket.inet_aton(name))
    except OSError:
        return None


def read_networks(listing: object) -> object:
    """Read networks such as ``10.0.0.0/8``, separated by commas or white space.

    Raises
    ------
    ValueError
        An entry is not a network.
    """
    if not isinstance(listing, str):
        return listing
    return tuple(ip_network(entry) for entry in listing.replace(",", " ").split())


def _plain(address: Address) -> Address:
    if isinstance(address, IPv4Address):
        return address
    if address.ipv4_mapped is not None:
        return address.ipv4_mapped
    if address in _TRANSLATED:
        return IPv4Address(int(address) & 0xFFFFFFFF)
    return address
