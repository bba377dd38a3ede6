"""Permitted addresses of webhook receivers."""

import socket
from ipaddress import IPv4Address, IPv6Address, ip_network

import pytest
from hypothesis import given
from hypothesis import strategies as st

from broker.webhooks import literal_address, permitted
from broker.webhooks.addresses import read_networks

PUBLIC = ("1.1.1.1", "8.8.8.8", "93.184.215.14", "2606:4700::1111", "2a00:1450:4001::200e")
OURS_ALONE = (
    "0.0.0.0",
    "10.1.2.3",
    "100.64.0.1",
    "100.100.100.200",
    "127.0.0.1",
    "127.8.9.1",
    "168.63.129.16",
    "169.254.169.254",
    "172.16.0.1",
    "172.31.255.255",
    "192.0.0.192",
    "192.0.2.1",
    "192.168.1.1",
    "198.18.0.1",
    "224.0.0.1",
    "240.0.0.1",
    "255.255.255.255",
    "::",
    "::1",
    "fc00::1",
    "fd00:ec2::254",
    "fe80::1",
    "fe80::1%eth0",
    "fec0::1",
    "ff02::1",
    "2001:db8::1",
    "2002:7f00:1::",
    "2001:0:1::1",
    "64:ff9b:1::7f00:1",
)


@pytest.mark.parametrize("address", PUBLIC)
def test_public_addresses_are_permitted(address: str) -> None:
    assert permitted(address)


@pytest.mark.parametrize("address", OURS_ALONE)
def test_other_addresses_are_not_permitted(address: str) -> None:
    assert not permitted(address)
    assert permitted(address, (ip_network("0.0.0.0/0"), ip_network("::/0")))


@given(st.integers(0, 2**32 - 1))
def test_an_ipv4_address_is_the_same_in_every_notation(number: int) -> None:
    plain = permitted(str(IPv4Address(number)))
    assert permitted(str(IPv6Address(0xFFFF << 32 | number))) is plain
    assert permitted(str(IPv6Address((0x64FF9B << 96) | number))) is plain
    for written in (str(number), hex(number), str(IPv4Address(number))):
        found = literal_address(written)
        assert found == str(IPv4Address(number)) == socket.inet_ntoa(socket.inet_aton(written))


@pytest.mark.parametrize(
    ("host", "address"),
    [
        ("127.1", "127.0.0.1"),
        ("0177.0.0.1", "127.0.0.1"),
        ("localhost", "127.0.0.1"),
        ("LOCALHOST.", "127.0.0.1"),
        ("a.localhost", "127.0.0.1"),
        ("::1", "::1"),
        ("fe80::1%eth0", "fe80::1"),
        ("example.org", None),
        ("127.0.0.1.example.org", None),
        ("localhost.example.org", None),
        ("999.1.1.1", None),
        ("", None),
    ],
)
def test_names_that_denote_addresses(host: str, address: str | None) -> None:
    assert literal_address(host) == address


def test_allowed_networks() -> None:
    networks = read_networks("10.0.0.0/8, 192.168.1.7\nfd00::/8")
    assert isinstance(networks, tuple)
    for address in ("10.9.9.9", "::ffff:10.9.9.9", "192.168.1.7", "fd00::5"):
        assert permitted(address, networks)
    assert permitted("1.1.1.1", networks)
    for address in ("192.168.1.8", "127.0.0.1", "fc00::5"):
        assert not permitted(address, networks)
    for wrong in ("10.0.0.1/8", "house", "10.0.0.0/33"):
        with pytest.raises(ValueError, match=r"bits set|does not appear"):
            read_networks(wrong)
