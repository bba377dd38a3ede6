"""Keys: those of one tenant, and of no other."""

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from broker.contracts import TENANT_NAME
from broker.store import DEFAULT_KEYS, Keys

names = st.from_regex(TENANT_NAME, fullmatch=True)


@given(names, st.text(max_size=20))
def test_a_key_tells_whose_it_is(name: str, record: str) -> None:
    keys = Keys(name)
    for key in (keys.shape(record), keys.job_result(record), keys.shapes, keys.held):
        assert Keys.owning(key) == keys


@given(names, names)
def test_no_key_is_that_of_two_tenants(one: str, other: str) -> None:
    assume(one != other)
    assert Keys(one).shape("a") != Keys(other).shape("a")
    # Keys of the default tenant are those from before there were tenants.
    assume(other != "default")
    assert not Keys(one).prefix.startswith(Keys(other).prefix)


def test_the_default_tenant_has_the_keys_from_before_there_were_tenants() -> None:
    assert Keys("default") == DEFAULT_KEYS
    assert DEFAULT_KEYS.shape("a") == "isomatch:shape:a"
    assert Keys("acme").shape("a") == "isomatch:tenant:acme:shape:a"


@pytest.mark.parametrize("name", ["", "a:b", "a/b", "a b", "a" * 65, "a\n"])
def test_names_that_keys_or_paths_cannot_have(name: str) -> None:
    with pytest.raises(ValueError, match="no tenant"):
        Keys(name)
