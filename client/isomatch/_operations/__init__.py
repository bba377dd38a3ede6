"""Operations: what is asked of the service and what an answer means, once for both clients."""

from isomatch._operations.prototype import ArchiveSource
from isomatch._operations.resources import id_of

__all__ = ["ArchiveSource", "id_of"]
