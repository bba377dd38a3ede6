"""Settings from the environment: common configuration and types, and their error messages."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import AfterValidator, BeforeValidator, ValidationError
from pydantic_settings import BaseSettings, SettingsConfigDict
from redis.connection import parse_url

FROM_ENVIRONMENT: Final = SettingsConfigDict(
    env_prefix="ISOMATCH_",
    # An empty address would mean all addresses, an empty directory the present one.
    env_ignore_empty=True,
    frozen=True,
)


_NEAR: Final = 0.85
"""Similarity of two names, from 0 to 1, from which on one is taken for the other misspelt."""

_OF_OTHERS: Final = (
    "ISOMATCH_URL",
    "ISOMATCH_API_KEY",
    "ISOMATCH_DATA",
    "ISOMATCH_JOB_MEMORY_MB",
    "ISOMATCH_REDIS_PATIENCE",
    "ISOMATCH_WORKER_PATIENCE",
)
"""Variables of clients, of benchmarks, or of either API or workers, which share an environment."""


def _redis_url(url: str) -> str:
    try:
        parse_url(url)
    except ValueError:
        # The error may quote a part of the password.
        raise ValueError(
            "not an address of a Redis, such as redis://:PASSWORD@HOST:6379/0; characters such as"
            " / # ? % of the password must be percent-encoded"
        ) from None
    return url


def _upper(level: object) -> object:
    return level.upper() if isinstance(level, str) else level


RedisUrl: TypeAlias = Annotated[str, AfterValidator(_redis_url)]
"""``redis://``, ``rediss://`` or ``unix://``."""

LogLevel: TypeAlias = Annotated[
    Literal["DEBUG", "INFO", "WARNING", "ERROR", "CRITICAL"], BeforeValidator(_upper)
]
"""Name of a log level, in upper or lower case."""


def misspelt_variables(given: Iterable[str], settings: type[BaseSettings]) -> dict[str, str]:
    """Return variables that are no settings but are spelt nearly so, with the setting meant.

    Others that begin alike may be those of clients and other processes.

    Parameters
    ----------
    given
        Names of the variables of the environment.
    settings
        Their names in upper case, after the prefix, are the variables that are read.
    """
    prefix = FROM_ENVIRONMENT["env_prefix"]
    known = [f"{prefix}{name}".upper() for name in settings.model_fields]
    found = {}
    for name in given:
        if name.startswith(prefix) and name not in (*known, *_OF_OTHERS):
            for near in get_close_matches(name, known, n=1, cutoff=_NEAR):
                found[name] = near
    return found


def setting_errors(error: ValidationError) -> list[str]:
    """Return one line for each invalid setting: its variable, and the error."""
    return [
        f"{FROM_ENVIRONMENT['env_prefix']}{'_'.join(map(str, item['loc'])).upper()}: "
        + item["msg"].removeprefix("Value error, ")
        for item in error.errors()
    ]
