"""Correspondences of less energy than the answer of a match."""

from typing import Final

from isomatch._results import Match

NEGLIGIBLE: Final = 1e-4
"""Relative difference up to which energies are the same, as for certificates."""


def less_energy(match: Match) -> str | None:
    """Return why correspondences of less energy were not chosen; None if there are none."""
    limit = match.energy - NEGLIGIBLE * abs(match.energy)
    known = []
    if any(other.energy < limit for other in match.alternatives):
        known.append("an alternative")
    if match.proof is not None and match.proof.energy < limit:
        known.append("a correspondence of all samples")
    if match.confidence is None or not known:
        return None
    reason = "tells it from others, such as the mirror image"
    if match.confidence.in_doubt:
        reason = "is in doubt here"
    return (
        f"of {' and '.join(known)}, but the answer was chosen by registration in space,"
        f" which {reason}"
    )
