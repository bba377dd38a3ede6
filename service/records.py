"""Shapes, prototypes and attribute files as requests name them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from broker.contracts import AttributesRecord, FieldProblem, PrototypeRecord, ShapeRecord
from broker.store import RecordStore, Store
from service.dependencies import Service
from service.http import ApiProblem

RecordT = TypeVar("RecordT", ShapeRecord, PrototypeRecord, AttributesRecord)


@dataclass(frozen=True)
class RecordKind(Generic[RecordT]):
    """One kind of records.

    Parameters
    ----------
    noun
        What a record is: "shape".
    records
        Returns the part of the store that keeps them.
    remedy
        What to do about one that has expired: "upload it again".
    not_found, expired
        The problems of an address without a record.
    """

    noun: str
    records: Callable[[Store], RecordStore[RecordT]]
    remedy: str
    not_found: type[ApiProblem]
    expired: type[ApiProblem]

    def missing(self, service: Service, record_id: str) -> ApiProblem:
        """Return the problem that a record is not there."""
        if self.records(service.store).expired(record_id):
            return self.expired(f"The {self.noun} {self._expiry}.")
        return self.not_found(f"There is no {self.noun} {record_id}.")

    def unknown(self, service: Service, field: str, record_id: str) -> FieldProblem:
        """Return the problem that a field of a request names a record that is not there."""
        message = f"there is no {self.noun} {record_id}"
        if self.records(service.store).expired(record_id):
            message = f"{self.noun} {record_id} {self._expiry}"
        return FieldProblem(field=field, message=message)

    def delete(self, service: Service, record_id: str) -> None:
        """Delete a record.

        Raises
        ------
        ApiProblem
            There is none.
        """
        if not self.records(service.store).delete(record_id):
            raise self.not_found(f"There is no {self.noun} {record_id}.")

    @property
    def _expiry(self) -> str:
        return f"was not used for long and is no longer kept; {self.remedy}"
