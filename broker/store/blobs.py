"""References in Redis to blobs, which hold the large bytes.

A reference is a hash with one field: the blob's token, its size and the SHA-256 of its bytes. The
blob's path follows from the reference's key and the token, so that whoever finds a blob finds the
reference to it, or sees that there is none. The token is new each time: a blob is never
overwritten, and a process that comes late deletes only its own.

A blob is written before its reference, and deleted after it. A process that is killed in between
leaves an *orphan*, a blob without a reference, which :mod:`broker.upkeep` deletes; never a
reference without a blob. A blob expires with its reference, which has the time to live.
"""

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import BinaryIO, Final, Self
from uuid import uuid4

from redis import Redis
from redis.client import Pipeline
from redis.exceptions import ResponseError

from broker.blobs import BlobEntry, BlobError, BlobLost, BlobsAway, BlobStore, NotMigrated
from broker.contracts import sha256_of
from broker.store import scripts
from broker.store.keys import PREFIX, Keys
from broker.store.replies import text
from broker.telemetry import logger

FOLDERS: Final = tuple(f"{number:02x}" for number in range(256))
"""Folders of the blobs, by the first two digits of the token: all of about one size."""

_FIELD: Final = "blob"
_NAME: Final = re.compile(r"[A-Za-z0-9._:-]+")
"""Keys whose blobs have a path: file systems and servers agree on these characters."""

_PIECE: Final = 256 * 1024
"""Bytes that are read at a time; of each answer that is sent, one or two pieces are in memory."""

_MARK: Final = "owner/id"
"""Path of the blob that names the Redis of this blob store."""

log = logger("isomatch.blobs")


@dataclass(frozen=True)
class BlobReference:
    """A reference as it is stored.

    Parameters
    ----------
    token
        Distinguishes this blob from others under the same key; 32 hexadecimal digits.
    size
        Number of bytes.
    digest
        SHA-256 of the bytes, hexadecimal.
    """

    token: str
    size: int
    digest: str

    def __str__(self) -> str:
        return f"{self.token} {self.size} {self.digest}"

    @classmethod
    def read(cls, stored: bytes | str) -> Self:
        """Return the reference that was stored as this text."""
        token, size, digest = text(stored).split()
        return cls(token, int(size), digest)

    def path(self, key: str) -> str:
        """Return the path of the blob that is referred to under a key.

        Raises
        ------
        ValueError
            The key has characters that paths do not have.
        """
        name = key.removeprefix(PREFIX)
        if not _NAME.fullmatch(name):
            raise ValueError(f"no blob can be kept under the key {key!r}")
        return f"{self.token[:2]}/{name.replace(':', '!')}!{self.token}"


def referring_key(path: str) -> tuple[str, str]:
    """Return the key of the reference to a blob, and the token of the blob, by its path.

    Of another file, both are those of no reference.
    """
    name, _, token = path.rpartition("/")[2].rpartition("!")
    return PREFIX + name.replace("!", ":"), token


@dataclass(frozen=True)
class Blobs:
    """Bytes that are kept in the blob store and referred to in Redis.

    Every method that reads or writes bytes may raise :class:`~broker.blobs.BlobError`.

    Parameters
    ----------
    client
        Connection to Redis.
    store
        The blob store.
    """

    client: Redis
    store: BlobStore

    def put(self, key: str, data: bytes | BinaryIO, digest: str | None = None) -> BlobReference:
        """Store bytes or a file, and return the reference that is to be linked under a key.

        Their SHA-256 is computed if it is not known.
        """
        found = BlobReference(uuid4().hex, size_of(data), digest or sha256_of(data))
        self.store.put(found.path(key), data)
        return found

    def put_all(
        self, contents: Mapping[str, bytes], digests: Mapping[str, str] = MappingProxyType({})
    ) -> dict[str, BlobReference]:
        """Store bytes under several keys, all or none, and return the references by key.

        The SHA-256 of some may be known.
        """
        stored: dict[str, BlobReference] = {}
        try:
            for key, data in contents.items():
                stored[key] = self.put(key, data, digests.get(key))
        except BlobError:
            # On a disk that is full, what is useless must not wait for the sweep.
            self.discard(stored.items())
            raise
        return stored

    def link(self, key: str, reference: BlobReference, pipe: Pipeline) -> None:
        """Store a reference in place of an earlier one, as part of a transaction."""
        pipe.delete(key)
        pipe.hset(key, _FIELD, str(reference))
        scripts.HOLD(pipe, [Keys.owning(key).held], key, reference.size)

    def unlink(self, keys: Iterable[str], pipe: Pipeline) -> None:
        """Delete references, as part of a transaction; their blobs are to be discarded."""
        for key in keys:
            pipe.delete(key)
            scripts.RELEASE(pipe, [Keys.owning(key).held], key)

    def save(self, key: str, data: bytes, seconds: int) -> None:
        """Store bytes and the reference to them, for some seconds."""
        reference = self.put(key, data)
        with self.client.pipeline() as pipe:
            self.look_up(key, pipe)
            self.link(key, reference, pipe)
            pipe.expire(key, seconds)
            earlier, *stored = pipe.execute(raise_on_error=False)
        for reply in stored:
            if isinstance(reply, Exception):
                raise reply
        # A transaction that is sent again because its reply was lost finds its own reference.
        if earlier != str(reference).encode():
            self.discard([(key, earlier)])

    def look_up(self, key: str, pipe: Pipeline) -> None:
        """Read a reference, as part of a transaction: its reply is for :meth:`read`."""
        pipe.hget(key, _FIELD)

    def reference(self, key: str) -> BlobReference | None:
        """Return the reference that is stored under a key.

        Raises
        ------
        NotMigrated
            The bytes are still in Redis.
        """
        with self.client.pipeline(transaction=False) as pipe:
            self.look_up(key, pipe)
            (reply,) = pipe.execute(raise_on_error=False)
        return _reference(key, reply)

    def get(self, key: str) -> bytes | None:
        """Return the bytes that are referred to under a key, None if there is no reference."""
        with self.client.pipeline(transaction=False) as pipe:
            self.look_up(key, pipe)
            (reply,) = pipe.execute(raise_on_error=False)
        return self.read(key, reply)

    def read(self, key: str, reply: object) -> bytes | None:
        """Return the bytes of a reference, by the reply to :meth:`look_up`.

        Raises
        ------
        BlobLost
            The bytes are missing or damaged.
        BlobsAway
            The blob store does not answer, or is that of another Redis.
        NotMigrated
            The bytes are still in Redis.
        """
        reference = _reference(key, reply)
        if reference is None:
            return None
        try:
            data = self.store.read(reference.path(key))
        except BlobLost:
            # Deleted, or replaced, after its reference was read?
            if self.reference(key) != reference:
                return self.get(key)
            self.check_owner()  # else all are missing, as where a volume is not mounted
            raise
        if len(data) != reference.size or sha256_of(data) != reference.digest:
            raise BlobLost(reference.path(key), "damaged")
        return data

    def open(self, key: str) -> BinaryIO | None:
        """Return bytes as a file, which is read twice: before, to compare its digest.

        Raises
        ------
        BlobLost
            The bytes are missing or damaged.
        BlobsAway
            The blob store does not answer, or is that of another Redis.
        """
        reference = self.reference(key)
        if reference is None:
            return None
        try:
            file = self.store.open(reference.path(key))
        except BlobLost:
            if self.reference(key) != reference:
                return self.open(key)
            self.check_owner()
            raise
        try:
            is_whole = size_of(file) == reference.size and sha256_of(file) == reference.digest
        except OSError as error:
            file.close()
            raise BlobsAway(f"the blob store cannot be read: {error}") from error
        if not is_whole:
            file.close()
            raise BlobLost(reference.path(key), "damaged")
        return file

    def lost(self, keys: Iterable[str]) -> bool:
        """Whether a blob is missing, or not of its size, though one of these keys refers to it.

        Raises
        ------
        BlobsAway
            The blob store does not answer, or is that of another Redis.
        """
        return any(map(self._lost, keys))

    def _lost(self, key: str) -> bool:
        try:
            reference = self.reference(key)
        except NotMigrated:
            return False
        if reference is None:
            return False
        try:
            found = self.store.size(reference.path(key))
        except BlobLost:
            if self.reference(key) != reference:
                return self._lost(key)
            self.check_owner()
            return True
        return found != reference.size

    def discard(self, found: Iterable[tuple[str, object]]) -> None:
        """Delete blobs whose references were deleted; where that fails, the sweep will.

        Parameters
        ----------
        found
            Keys, each with its reference or the reply to :meth:`look_up`.
        """
        for key, reply in found:
            if isinstance(reply, bytes | str):
                reply = BlobReference.read(reply)
            if not isinstance(reply, BlobReference):
                continue  # there was none
            try:
                self.store.delete(reply.path(key))
            except BlobError as error:
                log.warning("a blob is left to the sweep", key=key, error=str(error))

    def orphans(self, entries: list[BlobEntry]) -> Iterator[BlobEntry]:
        """Return the blobs of a listing that no reference names; count the others as held.

        They are counted when they are linked: here those are that earlier versions have linked.
        """
        named = [referring_key(entry.path) for entry in entries]
        with self.client.pipeline(transaction=False) as pipe:
            for key, _ in named:
                self.look_up(key, pipe)
            replies = pipe.execute(raise_on_error=False)
        with self.client.pipeline(transaction=False) as pipe:
            for entry, (key, token), reply in zip(entries, named, replies, strict=True):
                if isinstance(reply, Exception) and not _is_wrong_type(reply):
                    raise reply
                reference = BlobReference.read(reply) if isinstance(reply, bytes) else None
                if reference is None or reference.token != token:
                    yield entry
                else:
                    pipe.zadd(Keys.owning(key).held, {key: reference.size}, nx=True)
            pipe.execute()

    def check(self) -> None:
        """Check that blobs can be stored, and that the blob store belongs to this Redis.

        Raises
        ------
        BlobsAway, BlobsFull
            It cannot be used, or belongs to another Redis.
        """
        self.store.check()
        self.check_owner()

    def check_owner(self) -> None:
        """Check that the blob store belongs to this Redis; an unused one does from now on.

        A Redis that has lost its data, or is the wrong one, names none of the blobs. Without this,
        the sweep would delete them all.

        Raises
        ------
        BlobsAway
            The blob store belongs to another Redis, or is not the one that was used before.
        """
        self.client.hsetnx(Keys.BLOB_OWNER, "id", uuid4().hex)
        owner, marked = self.client.hmget(Keys.BLOB_OWNER, ["id", "marked"])
        assert owner is not None
        if marked is None:
            self.store.check()  # makes the directory of a new installation
        mark = self._mark()
        if mark is None and marked is None:
            self.store.put(_MARK, owner if isinstance(owner, bytes) else owner.encode())
            mark = self._mark()
        if mark != text(owner):
            what = "is empty" if mark is None else "belongs to another Redis"
            raise BlobsAway(
                f"the blob store {what}: ISOMATCH_BLOB_URL and ISOMATCH_REDIS_URL do not name the"
                " same installation (docs/operations.md, Backup and restore)"
            )
        if marked is None:
            self.client.hset(Keys.BLOB_OWNER, "marked", "1")

    def _mark(self) -> str | None:
        try:
            return self.store.read(_MARK).decode()
        except BlobLost:
            return None


def size_of(content: bytes | BinaryIO) -> int:
    """Return the number of bytes of content; a file is left at its start."""
    if isinstance(content, bytes):
        return len(content)
    size = content.seek(0, os.SEEK_END)
    content.seek(0)
    return size


def pieces(file: BinaryIO) -> Iterator[bytes]:
    """Iterate over the rest of a file, a piece at a time."""
    while piece := file.read(_PIECE):
        yield piece


def _reference(key: str, reply: object) -> BlobReference | None:
    if isinstance(reply, Exception):
        raise NotMigrated(key) if _is_wrong_type(reply) else reply
    return BlobReference.read(reply) if isinstance(reply, bytes | str) else None


def _is_wrong_type(error: Exception) -> bool:
    # Earlier versions stored the bytes themselves under the key, a string and not a hash.
    return isinstance(error, ResponseError) and str(error).startswith("WRONGTYPE")
