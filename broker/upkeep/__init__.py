"""Recovery of jobs whose worker died, and retention: what is kept for how long."""

from broker.upkeep.recovery import (
    LOSSES_AFTER_KILL,
    LOSSES_WITH_WORKER,
    Patience,
    forget_workers,
    give_back,
    recover,
)
from broker.upkeep.retention import Sweep, forget_deleted

__all__ = [
    "LOSSES_AFTER_KILL",
    "LOSSES_WITH_WORKER",
    "Patience",
    "Sweep",
    "forget_deleted",
    "forget_workers",
    "give_back",
    "recover",
]
