"""Settings from the environment: common configuration and types, and their error messages."""

from typing import Annotated, Final, Literal, TypeAlias

from pydantic import AfterValidator, BeforeValidator, ValidationError
from pydantic_settings import SettingsConfigDict
from redis.connection import parse_url

FROM_ENVIRONMENT: Final = SettingsConfigDict(
    env_prefix="ISOMATCH_",
    # An empty address would mean all addresses, an empty directory the present one.
    env_ignore_empty=True,
    frozen=True,
)


def _redis_url(url: str) -> str:
    parse_url(url)
    return url


def _upper(level: object) -> object:
    return level.upper() if isinstance(level, str) else level


RedisUrl: TypeAlias = Annotated[str, AfterValidator(_redis_url)]
"""``redis://``, ``rediss://`` or ``unix://``."""

LogLevel: TypeAlias = Annotated[
    Literal["DEBUG", "INFO", "WARNING", "ERROR", "CRITICAL"], BeforeValidator(_upper)
]
"""Name of a log level, in upper or lower case."""


def setting_errors(error: ValidationError) -> list[str]:
    """Return one line for each invalid setting: its variable, and the error."""
    return [
        f"{FROM_ENVIRONMENT['env_prefix']}{'_'.join(map(str, item['loc'])).upper()}: "
        + item["msg"].removeprefix("Value error, ")
        for item in error.errors()
    ]
