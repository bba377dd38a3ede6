"""Recovery of jobs whose process died; retention of records and blobs; migration."""

from broker.upkeep.migration import Migrated, migrate
from broker.upkeep.orphans import OrphanSweep
from broker.upkeep.periodic import Upkeep
from broker.upkeep.recovery import (
    LOSSES_AFTER_KILL,
    LOSSES_WITH_WORKER,
    RecoveryTimeouts,
    first_loss,
    handle_lost_process,
    recover,
    store_away,
    unregister_workers,
)
from broker.upkeep.retention import Sweep, evict_deleted

__all__ = [
    "LOSSES_AFTER_KILL",
    "LOSSES_WITH_WORKER",
    "Migrated",
    "OrphanSweep",
    "RecoveryTimeouts",
    "Sweep",
    "Upkeep",
    "evict_deleted",
    "first_loss",
    "handle_lost_process",
    "migrate",
    "recover",
    "store_away",
    "unregister_workers",
]
