"""Transactions that are repeated until no key that they watch changes meanwhile."""

from collections.abc import Callable
from typing import TypeVar, cast

from redis import Redis
from redis.client import Pipeline

ResultT = TypeVar("ResultT")


def transact(client: Redis, attempt: Callable[[Pipeline], ResultT]) -> ResultT:
    """Execute the commands of `attempt` in one transaction, and return its value.

    Parameters
    ----------
    client
        Connection to Redis.
    attempt
        Watches keys, reads, and begins the transaction. It is called again whenever a key that it
        watches has changed before the transaction.
    """
    # Annotated in redis-py as if functions had no value.
    answer = client.transaction(attempt, value_from_callable=True)  # type: ignore[arg-type]
    return cast(ResultT, answer)
