"""Values taken from requests: nothing is converted, and nothing unknown is accepted."""

from dataclasses import dataclass

from pydantic import BaseModel, ConfigDict


class StrictModel(BaseModel):
    """A frozen value of declared fields, finite numbers and exact types only."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)


@dataclass(frozen=True)
class Topic:
    """Heading under which a parameter is documented: an annotation of its field.

    Parameters
    ----------
    name
        The heading; "" for parameters that most users look for first.
    """

    name: str
