"""Server-sent events (https://html.spec.whatwg.org, section 9.2), the fields that jobs use."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Event:
    """One event.

    Attributes
    ----------
    data
        Text of the event.
    id
        Id by which a client resumes the stream after it.
    """

    data: str
    id: str | None


@dataclass
class EventReader:
    """Parser that assembles the lines of a stream into events."""

    _data: list[str] = field(default_factory=list)
    _id: str | None = None

    def feed(self, line: str) -> Event | None:
        """Read the next line, without its end; return the event that it completes, if any."""
        if not line:
            data, self._data = self._data, []
            return Event("\n".join(data), self._id) if data else None
        name, _, value = line.partition(":")
        value = value.removeprefix(" ")
        if name == "data":
            self._data.append(value)
        elif name == "id" and "\0" not in value:
            self._id = value
        return None
