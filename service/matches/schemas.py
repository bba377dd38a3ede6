"""Requests to match a shape or a prototype with a shape."""

from pydantic import ConfigDict, Field

from broker.contracts import MatchParameters
from service.jobs import JobRequest
from service.names import ID_PATTERN, ShapeName


class SourceRequest(MatchParameters, JobRequest):
    """A source, a shape or a prototype, and how to match it."""

    source: str = Field(
        pattern=ID_PATTERN,
        description="Id of the source: a shape, or a prototype, whose ids begin with `p-`.",
    )
    source_name: ShapeName | None = Field(
        default=None,
        description="Name of the source in the result, such as that of this upload of its file;"
        " null for the name it is stored under.",
    )


class MatchRequest(SourceRequest):
    """Two shapes, or a prototype and a shape, and how to match them."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "source": "9b74c9897bac770ffc029102a200c5de",
                    "target": "37b51d194a7513e45b56f6524f2d51f2",
                    "points": 32,
                    "webhook": {
                        "url": "https://example.org/isomatch",
                        "secret": "at-least-sixteen-characters",
                    },
                },
                {
                    "source": "9b74c9897bac770ffc029102a200c5de",
                    "target": "37b51d194a7513e45b56f6524f2d51f2",
                    "points": 16,
                    "metric": [{"name": "diffusion", "time": 0.02}, "geodesic"],
                    "descriptor": {"name": "geodesic_histogram", "bins": 12},
                    "first_order_weight": 0.2,
                },
                {
                    "source": "9b74c9897bac770ffc029102a200c5de",
                    "target": "37b51d194a7513e45b56f6524f2d51f2",
                    "points": 64,
                    "refine": "gmds",
                },
                {
                    "source": "p-1f0c2f0e3b9d4c0c8e6f1a2b3c4d5e6f",
                    "target": "37b51d194a7513e45b56f6524f2d51f2",
                },
                {
                    "source": "9b74c9897bac770ffc029102a200c5de",
                    "target": "37b51d194a7513e45b56f6524f2d51f2",
                    "landmarks": [[17, 203], [1040, 88]],
                    "dense": True,
                },
            ]
        }
    )

    target: str = Field(pattern=ID_PATTERN, description="Id of the target shape.")
    target_name: ShapeName | None = Field(
        default=None, description="Name of the target in the result, likewise."
    )
