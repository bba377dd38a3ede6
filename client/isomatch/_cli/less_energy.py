"""Correspondences of less energy than the answer of a match."""

from typing import Final

from isomatch._results import Match

NEGLIGIBLE: Final = 1e-4
"""Relative difference up to which energies are the same, as for certificates."""


def less_energy(match: Match) -> str | None:
    """Return which correspondences have less energy, and what chose the answer; None if none."""
    limit = match.energy - NEGLIGIBLE * abs(match.energy)
    known = []
    if any(other.energy < limit for other in match.alternatives):
        known.append("one alternative")
    if match.proof is not None and match.proof.energy < limit:
        known.append("one correspondence of all samples")
    if match.confidence is None or not known:
        return None
    have = "has" if len(known) == 1 else "have"
    doubt = ", which is in doubt" if match.confidence.in_doubt else ""
    return (
        f"{' and '.join(known)} {have} less energy; registration in space chose this answer{doubt}"
    )
