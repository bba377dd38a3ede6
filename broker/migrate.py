"""``python -m broker.migrate``: move what earlier versions kept in Redis to the blob store."""

import sys

from pydantic import ValidationError
from redis.exceptions import RedisError

from broker.blobs import BlobError
from broker.environment import setting_errors
from broker.store import Store, StoreSettings
from broker.telemetry import configure_logging
from broker.upkeep import migrate


def main() -> int:
    """Migrate the store that ``ISOMATCH_REDIS_URL`` and ``ISOMATCH_BLOB_URL`` name."""
    configure_logging("INFO", process="migrate")
    try:
        store = Store.open(StoreSettings(), retry_seconds=10.0)
        moved = migrate(store)
    except ValidationError as error:
        print("\n".join(f"migrate: {line}" for line in setting_errors(error)), file=sys.stderr)
        return 2
    except (ValueError, RedisError, BlobError) as error:
        print(f"migrate: {error}", file=sys.stderr)
        return 1
    print(f"moved {moved.values} values of {moved.bytes / 1e6:.1f} MB to the blob store")
    store.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
