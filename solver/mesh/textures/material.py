"""Materials: what a surface has besides its base colour and its image."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """A material of the metallic-roughness model, without its base colour.

    Parameters
    ----------
    name
        Its name; empty if it has none.
    metallic
        Metalness in 0..1: 0 is no metal.
    roughness
        Roughness in 0..1: 1 is matte.
    """

    name: str = ""
    metallic: float = 0.0
    roughness: float = 1.0
