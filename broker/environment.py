"""Settings from the environment: the types several of them share, and what is wrong with them."""

from typing import Annotated, Final, Literal, TypeAlias

from pydantic import AfterValidator, BeforeValidator, ValidationError
from pydantic_settings import SettingsConfigDict
from redis.connection import parse_url

FROM_ENVIRONMENT: Final = SettingsConfigDict(
    env_prefix="ISOMATCH_",
    # An empty address would be taken for all addresses, an empty directory for the present one.
    env_ignore_empty=True,
    frozen=True,
)


def _redis_url(url: str) -> str:
    parse_url(url)  # type: ignore[no-untyped-call]
    return url


def _upper(level: object) -> object:
    return level.upper() if isinstance(level, str) else level


RedisUrl: TypeAlias = Annotated[str, AfterValidator(_redis_url)]
"""``redis://``, ``rediss://`` or ``unix://``."""

LogLevel: TypeAlias = Annotated[
    Literal["DEBUG", "INFO", "WARNING", "ERROR", "CRITICAL"], BeforeValidator(_upper)
]
"""Name of a level, in either case."""


def complaints(error: ValidationError) -> list[str]:
    """Return what is wrong with which setting, a line each."""
    return [
        f"{FROM_ENVIRONMENT['env_prefix']}{'_'.join(map(str, item['loc'])).upper()}: "
        + item["msg"].removeprefix("Value error, ")
        for item in error.errors()
    ]
