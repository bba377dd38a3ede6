"""Server-sent events, https://html.spec.whatwg.org, section 9.2, as far as jobs have them."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Event:
    """One event.

    Attributes
    ----------
    data
        What it tells.
    id
        What the client says it has seen when it comes back.
    """

    data: str
    id: str | None


@dataclass
class EventReader:
    """Puts the lines of a stream together to events."""

    _data: list[str] = field(default_factory=list)
    _id: str | None = None

    def feed(self, line: str) -> Event | None:
        """Take in the next line, without its end; return the event that it ends, if it does."""
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
