"""Recovery of jobs whose process died, and retention of records in listings and cache."""

from broker.upkeep.recovery import (
    LOSSES_AFTER_KILL,
    LOSSES_WITH_WORKER,
    RecoveryTimeouts,
    first_loss,
    handle_lost_process,
    recover,
    unregister_workers,
)
from broker.upkeep.retention import Sweep, evict_deleted

__all__ = [
    "LOSSES_AFTER_KILL",
    "LOSSES_WITH_WORKER",
    "RecoveryTimeouts",
    "Sweep",
    "evict_deleted",
    "first_loss",
    "handle_lost_process",
    "recover",
    "unregister_workers",
]
